within IT2Hysteresis.Functions.Effects;
function loadInverse "Inverse of the elastic load"
  extends Modelica.Icons.Function;
  input Real c(unit="m/N") "Compliance";
  input Modelica.Units.SI.Length y "Displacement";
  input Modelica.Units.SI.Force F "Force, compressive positive";
  output Modelica.Units.SI.Length x "Displacement without the force";
algorithm
  x := y + c*F;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.Effects.<strong>loadInverse</strong>(c, y, F);
</pre>
<h4>Description</h4>
<p>x<sub>k</sub> = y<sub>k</sub> + c F<sub>k</sub>.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end loadInverse;
