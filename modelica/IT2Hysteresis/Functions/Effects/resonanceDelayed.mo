within IT2Hysteresis.Functions.Effects;
function resonanceDelayed "Resonating displacement of up to two ticks ago"
  extends Modelica.Icons.Function;
  input Real ticks(unit="1", min=0, max=2) "Delay in ticks";
  input Modelica.Units.SI.Length y "Output of the resonance at this tick, y_k";
  input Modelica.Units.SI.Length y1 "The same at the tick before, y_{k-1}";
  input Modelica.Units.SI.Length y2 "The same two ticks before, y_{k-2}";
  output Modelica.Units.SI.Length later "Delayed displacement";
algorithm
  later := if ticks > 1 then y1 + (ticks - 1)*(y2 - y1) else y + ticks*(y1 - y);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
later = Functions.Effects.<strong>resonanceDelayed</strong>(ticks, y, y1, y2);
</pre>
<h4>Description</h4>
<p>
The output of the <a href=\"modelica://IT2Hysteresis.Functions.Effects.resonance\">resonance</a> ticks sample times ago, straight between
ticks. There is no inverse; the inverse block drives the chain without this delay.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end resonanceDelayed;
