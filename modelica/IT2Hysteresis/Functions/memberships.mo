within IT2Hysteresis.Functions;
function memberships "Memberships f_l + F_l, (8), (9), (11), (12)"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Modelica.Units.SI.Length yPrevious "Displacement at the tick before, y_{k-1}";
  output Real w[size(s1, 1)](each final unit="1") "f_l + F_l, up to a common factor";
protected
  constant Modelica.Units.SI.Length farthest=1e140 "Its square is finite";
  Modelica.Units.SI.Length d "Distance to a centre";
  Real scale=-Modelica.Constants.inf "Largest exponent: a common factor of all memberships changes nothing";
algorithm
  for l in 1:size(s1, 1) loop
    d := min(max(yPrevious - c[l], -farthest), farthest);
    scale := max(scale, -d^2/(2*max(s1[l], s2[l])^2));
  end for;
  for l in 1:size(s1, 1) loop
    d := min(max(yPrevious - c[l], -farthest), farthest);
    w[l] := exp(-d^2/(2*s1[l]^2) - scale) + exp(-d^2/(2*s2[l]^2) - scale);
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
w = Functions.<strong>memberships</strong>(s1, s2, c, yPrevious);
</pre>
<h4>Description</h4>
<p>
w<sub>l</sub> = f<sub>l</sub> + F<sub>l</sub> with<br/>
f<sub>l</sub> = exp(-(y<sub>k-1</sub> - c<sub>l</sub>)<sup>2</sup> / (2 s<sub>l1</sub><sup>2</sup>)) &#160; (8), (11)<br/>
F<sub>l</sub> = exp(-(y<sub>k-1</sub> - c<sub>l</sub>)<sup>2</sup> / (2 s<sub>l2</sub><sup>2</sup>)) &#160; (9), (12)
</p>
<p>
Far from every centre all memberships would underflow, and (10) would be 0/0. So all of them are scaled by the largest. That
leaves (10) as it is and finite; its limit is the nearest rule, the one whose distance in units of its upper deviation is
smallest.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end memberships;
