within IT2Hysteresis.Functions.Effects;
function playStates "Play operators after a tick"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Voltage r[:] "Thresholds r_j, rising";
  input Modelica.Units.SI.Voltage pPrevious[size(r, 1)] "Play operators at the tick before, p_j,k-1";
  input Modelica.Units.SI.Voltage x "Input at this tick, x_k";
  output Modelica.Units.SI.Voltage p[size(r, 1)] "Play operators at this tick, p_j,k";
algorithm
  for j in 1:size(r, 1) loop
    p[j] := min(max(pPrevious[j], x - r[j]), x + r[j]);
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
p = Functions.Effects.<strong>playStates</strong>(r, pPrevious, x);
</pre>
<h4>Description</h4>
<p>
p<sub>j,k</sub> = min(max(p<sub>j,k-1</sub>, x<sub>k</sub> - r<sub>j</sub>), x<sub>k</sub> + r<sub>j</sub>): an operator stays where it is until the
input is r<sub>j</sub> away, and then follows at that distance.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end playStates;
