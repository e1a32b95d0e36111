within IT2Hysteresis.Functions.Effects;
function lagInverse "Inverse of the first-order lag"
  extends Modelica.Icons.Function;
  input Real g(unit="1") "Part of the way that is gone in one tick, see gain";
  input Modelica.Units.SI.Voltage yPrevious "Output at the tick before, y_{k-1}";
  input Modelica.Units.SI.Voltage y "Output at this tick, y_k";
  output Modelica.Units.SI.Voltage x "Input at this tick, x_k";
algorithm
  x := yPrevious + (y - yPrevious)/g;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.Effects.<strong>lagInverse</strong>(g, yPrevious, y);
</pre>
<h4>Description</h4>
<p>x<sub>k</sub> = y<sub>k-1</sub> + (y<sub>k</sub> - y<sub>k-1</sub>)/g.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end lagInverse;
