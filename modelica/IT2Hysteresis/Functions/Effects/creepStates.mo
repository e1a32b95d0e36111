within IT2Hysteresis.Functions.Effects;
function creepStates "Creep states after a tick"
  extends Modelica.Icons.Function;
  input Real g[:](each unit="1") "Part of the way that is gone in one tick, g_i, see gain";
  input Modelica.Units.SI.Length sPrevious[size(g, 1)] "Creep states at the tick before, s_i,k-1";
  input Modelica.Units.SI.Length x "Displacement without creep, x_k";
  output Modelica.Units.SI.Length s[size(g, 1)] "Creep states at this tick, s_i,k";
algorithm
  for i in 1:size(g, 1) loop
    s[i] := sPrevious[i] + g[i]*(x - sPrevious[i]);
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
s = Functions.Effects.<strong>creepStates</strong>(g, sPrevious, x);
</pre>
<h4>Description</h4>
<p>
s<sub>i,k</sub> = s<sub>i,k-1</sub> + g<sub>i</sub> (x<sub>k</sub> - s<sub>i,k-1</sub>) with
<a href=\"modelica://IT2Hysteresis.Functions.Effects.gain\">g<sub>i</sub></a> = 1 - exp(-T<sub>s</sub>/&#964;<sub>i</sub>).
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end creepStates;
