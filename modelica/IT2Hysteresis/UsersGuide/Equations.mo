within IT2Hysteresis.UsersGuide;
class Equations "The model and its inverse"
  extends Modelica.Icons.Information;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>
Symbols and equation numbers are those of the paper, see
<a href=\"modelica://IT2Hysteresis.UsersGuide.References\">References</a>. x<sub>k</sub> is the voltage and
y<sub>k</sub> the displacement at tick k; l = 1 ... L counts the rules.
</p>
<h4>Rules</h4>
<p>
IF y<sub>k-1</sub> is A<sub>l</sub> THEN y<sub>k</sub> = q<sub>l1</sub> y<sub>k-1</sub> + q<sub>l2</sub> x<sub>k</sub> + q<sub>l3</sub> &#160; (7)
</p>
<h4>Memberships</h4>
<p>
A<sub>l</sub> is a Gaussian of centre c<sub>l</sub> whose standard deviation is uncertain. The smaller deviation
s<sub>l1</sub> bounds the membership from below, the larger one s<sub>l2</sub> from above:
</p>
<p>
f<sub>l</sub> = exp(-(y<sub>k-1</sub> - c<sub>l</sub>)<sup>2</sup> / (2 s<sub>l1</sub><sup>2</sup>)) &#160; (8), (11)<br/>
F<sub>l</sub> = exp(-(y<sub>k-1</sub> - c<sub>l</sub>)<sup>2</sup> / (2 s<sub>l2</sub><sup>2</sup>)) &#160; (9), (12)
</p>
<h4>Model</h4>
<p>
y<sub>k</sub> = &#931;<sub>l</sub> (q<sub>l1</sub> y<sub>k-1</sub> + q<sub>l2</sub> x<sub>k</sub> + q<sub>l3</sub>) (f<sub>l</sub> + F<sub>l</sub>)
/ &#931;<sub>l</sub> (f<sub>l</sub> + F<sub>l</sub>) &#160; (10)
</p>
<h4>Inverse</h4>
<p>
x<sub>k</sub> = (y<sub>k</sub> &#931;<sub>l</sub> (f<sub>l</sub> + F<sub>l</sub>) - &#931;<sub>l</sub> (q<sub>l1</sub> y<sub>k-1</sub> + q<sub>l3</sub>) (f<sub>l</sub> + F<sub>l</sub>))
/ &#931;<sub>l</sub> q<sub>l2</sub> (f<sub>l</sub> + F<sub>l</sub>) &#160; (30)
</p>
<p>with the memberships at the desired y<sub>k-1</sub>.</p>
<h4>Beyond the range</h4>
<p>
For y<sub>k-1</sub> beyond an end y<sub>e</sub> of the range displacementMin ... displacementMax, with the equilibrium
voltage x<sub>e</sub> and A = &#8706;y<sub>k</sub>/&#8706;x<sub>k</sub>, s = &#8706;y<sub>k</sub>/&#8706;y<sub>k-1</sub> of (10) there:
</p>
<p>
y<sub>k</sub> = y<sub>e</sub> + A (x<sub>k</sub> - x<sub>e</sub>) + s (y<sub>k-1</sub> - y<sub>e</sub>)
</p>
<p>and its solution for x<sub>k</sub>. It joins (10) at y<sub>e</sub> without a jump, whatever x<sub>k</sub> is.</p>
<h4>Where to find it</h4>
<table border=\"1\" cellspacing=\"0\" cellpadding=\"3\">
<tr><th>Equation</th><th>Function</th></tr>
<tr><td>(8), (9), (11), (12)</td><td><a href=\"modelica://IT2Hysteresis.Functions.memberships\">memberships</a></td></tr>
<tr><td>(7), (10)</td><td><a href=\"modelica://IT2Hysteresis.Functions.step\">step</a></td></tr>
<tr><td>(30)</td><td><a href=\"modelica://IT2Hysteresis.Functions.inverse\">inverse</a></td></tr>
<tr><td>A, s</td><td><a href=\"modelica://IT2Hysteresis.Functions.linearisation\">linearisation</a></td></tr>
<tr><td>within and beyond the range</td><td><a href=\"modelica://IT2Hysteresis.Functions.core\">core</a>,
<a href=\"modelica://IT2Hysteresis.Functions.coreInverse\">coreInverse</a></td></tr>
</table>
<table border=\"1\" cellspacing=\"0\" cellpadding=\"3\">
<tr><th>Symbol</th><th>Parameter</th><th>Unit</th></tr>
<tr><td>s<sub>l1</sub></td><td><code>ruleSigmaLower[l]</code></td><td>m</td></tr>
<tr><td>s<sub>l2</sub></td><td><code>ruleSigmaUpper[l]</code></td><td>m</td></tr>
<tr><td>c<sub>l</sub></td><td><code>ruleCentre[l]</code></td><td>m</td></tr>
<tr><td>q<sub>l1</sub></td><td><code>ruleQ1[l]</code></td><td>1</td></tr>
<tr><td>q<sub>l2</sub></td><td><code>ruleQ2[l]</code></td><td>m/V</td></tr>
<tr><td>q<sub>l3</sub></td><td><code>ruleQ3[l]</code></td><td>m</td></tr>
</table>
<p>
The paper's text suggests to read the antecedents of its Table 1 as (c, s1, s2). Read so, the model diverges under
the paper's own signal. The library reads them as (s1, s2, c): then s1 &lt; s2 in every rule, the centres span the travel
and the response to (22) covers the paper's range.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Equations;
