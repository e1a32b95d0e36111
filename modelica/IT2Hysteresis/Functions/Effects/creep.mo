within IT2Hysteresis.Functions.Effects;
function creep "Creep"
  extends Modelica.Icons.Function;
  input Real c[:](each unit="1") "Creep in the end, per displacement, c_i";
  input Modelica.Units.SI.Length s[size(c, 1)] "Creep states at this tick, s_i,k, see creepStates";
  input Modelica.Units.SI.Length x "Displacement without creep, x_k";
  output Modelica.Units.SI.Length y "Displacement, y_k";
algorithm
  y := x + c*s;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>creep</strong>(c, s, x);
</pre>
<h4>Description</h4>
<p>
y<sub>k</sub> = x<sub>k</sub> + &#931;<sub>i</sub> c<sub>i</sub> s<sub>i,k</sub>. Displacements and states are counted from the
sensor's zero, <code>displacementZero</code>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end creep;
