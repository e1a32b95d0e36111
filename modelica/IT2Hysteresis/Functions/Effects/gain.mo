within IT2Hysteresis.Functions.Effects;
function gain "Part of the way that a first-order lag goes in one sample time"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Time Ts "Sample time";
  input Modelica.Units.SI.Time tau "Time constant";
  output Real g(unit="1") "1 - exp(-Ts/tau)";
protected
  Real ratio=Ts/tau;
algorithm
  g := if ratio > 1 then 1 - exp(-ratio) else 2*exp(-ratio/2)*sinh(ratio/2);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
g = Functions.Effects.<strong>gain</strong>(Ts, tau);
</pre>
<h4>Description</h4>
<p>
g = 1 - exp(-T<sub>s</sub>/&#964;), without the digits that the difference loses where &#964; is much longer than
T<sub>s</sub>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end gain;
