within IT2Hysteresis.UsersGuide;
class Concept "A chain of invertible stages"
  extends Modelica.Icons.Information;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>
The actuator is a chain of small stages. Each maps one signal to one signal, keeps its own state and
has an inverse in closed form. The plant walks the chain forwards, from <code>voltage</code> to
<code>displacement</code>; the inverse walks it backwards, from <code>reference</code> to
<code>voltage</code>. Put in front of the plant, the inverse cancels the hysteresis:
</p>
<p><code>reference &#8594; inverse &#8594; voltage &#8594; plant &#8594; displacement = reference</code></p>
<p>
In the middle of the chain is the fuzzy system of the
<a href=\"modelica://IT2Hysteresis.UsersGuide.Equations\">equations</a>; the stages around it are
<a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">effects</a>, off by default. The inputs <code>force</code> and
<code>temperature</code> act through the effects load and drift.
</p>
<h4>Parameters</h4>
<p>
Plant and inverse take the same record,
<a href=\"modelica://IT2Hysteresis.Parameters.Base\">Parameters.Base</a>. The default is
<a href=\"modelica://IT2Hysteresis.Parameters.Table1\">Parameters.Table1</a>, the paper's actuator. Declare the
record once and hand it to both:
</p>
<pre>
parameter IT2Hysteresis.Parameters.Table1 stage(initialDisplacement=1e-6);
IT2Hysteresis.Blocks.Inverse inverse(parameters=stage);
IT2Hysteresis.Blocks.Plant plant(parameters=stage);
</pre>
<h4>Range</h4>
<p>
A parameter set is valid for <code>voltageMin</code> to <code>voltageMax</code> and
<code>displacementMin</code> to <code>displacementMax</code>. In that range the model is invertible and
contracting: a wrong initial displacement is forgotten. Beyond an end of the displacement range the fuzzy system goes on
as its <a href=\"modelica://IT2Hysteresis.Functions.linearisation\">linearisation</a> at the equilibrium of that end, so that it
contracts there too, and no voltage makes a run diverge; the paper's formula alone does, for Table 1 at any constant
voltage above 122.2 V. Such displacements are extrapolated: a plant that leaves the range says so with a warning, once,
and shows it on <code>outOfRange</code>. The inverse keeps its reference in the displacement range and its voltage in the
voltage range, and shows on <code>saturated</code> that it had to, until the plant is back.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Concept;
