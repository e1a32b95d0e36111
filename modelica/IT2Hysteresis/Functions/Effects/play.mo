within IT2Hysteresis.Functions.Effects;
function play "Prandtl-Ishlinskii operator of play operators"
  extends Modelica.Icons.Function;
  input Real w[:](each unit="1") "Weights w_j";
  input Modelica.Units.SI.Voltage p[size(w, 1)] "Play operators at this tick, p_j,k, see playStates";
  input Modelica.Units.SI.Voltage x "Input at this tick, x_k";
  output Modelica.Units.SI.Voltage h "Output at this tick, h_k";
algorithm
  h := x + w*p;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
h = Functions.Effects.<strong>play</strong>(w, p, x);
</pre>
<h4>Description</h4>
<p>
h<sub>k</sub> = x<sub>k</sub> + &#931;<sub>j</sub> w<sub>j</sub> p<sub>j,k</sub>: rate-independent memory in front of the fuzzy system.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end play;
