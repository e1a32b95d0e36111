within IT2Hysteresis.Functions.Effects;
function lag "First-order lag of the amplifier"
  extends Modelica.Icons.Function;
  input Real g(unit="1") "Part of the way that is gone in one tick, see gain";
  input Modelica.Units.SI.Voltage yPrevious "Output at the tick before, y_{k-1}";
  input Modelica.Units.SI.Voltage x "Input at this tick, x_k";
  output Modelica.Units.SI.Voltage y "Output at this tick, y_k";
algorithm
  y := yPrevious + g*(x - yPrevious);
  annotation (
    inverse(x=IT2Hysteresis.Functions.Effects.lagInverse(g, yPrevious, y)),
    Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>lag</strong>(g, yPrevious, x);
</pre>
<h4>Description</h4>
<p>
y<sub>k</sub> = y<sub>k-1</sub> + g (x<sub>k</sub> - y<sub>k-1</sub>) with
<a href=\"modelica://IT2Hysteresis.Functions.Effects.gain\">g</a> = 1 - exp(-T<sub>s</sub>/&#964;): the exact pole and no zero.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end lag;
