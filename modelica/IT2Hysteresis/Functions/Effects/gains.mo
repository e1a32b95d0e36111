within IT2Hysteresis.Functions.Effects;
function gains "The same for several lags"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Time Ts "Sample time";
  input Modelica.Units.SI.Time tau[:] "Time constants";
  output Real g[size(tau, 1)](each unit="1") "1 - exp(-Ts/tau)";
algorithm
  for i in 1:size(tau, 1) loop
    g[i] := IT2Hysteresis.Functions.Effects.gain(Ts, tau[i]);
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
g = Functions.Effects.<strong>gains</strong>(Ts, tau);
</pre>
<h4>Description</h4>
<p><a href=\"modelica://IT2Hysteresis.Functions.Effects.gain\">gain</a> of every time constant.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end gains;
