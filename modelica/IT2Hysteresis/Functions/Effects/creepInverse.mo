within IT2Hysteresis.Functions.Effects;
function creepInverse "Inverse of creep"
  extends Modelica.Icons.Function;
  input Real c[:](each unit="1") "Creep in the end, per displacement, c_i";
  input Real g[size(c, 1)](each unit="1") "Part of the way that is gone in one tick, g_i, see gain";
  input Modelica.Units.SI.Length sPrevious[size(c, 1)] "Creep states at the tick before, s_i,k-1";
  input Modelica.Units.SI.Length y "Displacement, y_k";
  output Modelica.Units.SI.Length x "Displacement without creep, x_k";
algorithm
  x := (y - sum(c .* (sPrevious - g .* sPrevious)))/(1 + sum(c .* g));
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.Effects.<strong>creepInverse</strong>(c, g, sPrevious, y);
</pre>
<h4>Description</h4>
<p>
Creep is affine in x for given states:
x<sub>k</sub> = (y<sub>k</sub> - &#931;<sub>i</sub> c<sub>i</sub> (1 - g<sub>i</sub>) s<sub>i,k-1</sub>) / (1 + &#931;<sub>i</sub> c<sub>i</sub> g<sub>i</sub>).
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end creepInverse;
