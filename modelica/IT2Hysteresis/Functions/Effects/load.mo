within IT2Hysteresis.Functions.Effects;
function load "Elastic load"
  extends Modelica.Icons.Function;
  input Real c(unit="m/N") "Compliance";
  input Modelica.Units.SI.Length x "Displacement without the force";
  input Modelica.Units.SI.Force F "Force, compressive positive";
  output Modelica.Units.SI.Length y "Displacement";
algorithm
  y := x - c*F;
  annotation (
    inverse(x=IT2Hysteresis.Functions.Effects.loadInverse(c, y, F)),
    Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>load</strong>(c, x, F);
</pre>
<h4>Description</h4>
<p>y<sub>k</sub> = x<sub>k</sub> - c F<sub>k</sub>.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end load;
