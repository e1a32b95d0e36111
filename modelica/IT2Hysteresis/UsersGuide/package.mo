within IT2Hysteresis;
package UsersGuide "User's Guide"
  extends Modelica.Icons.Information;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>
The library turns the voltage at a piezoelectric actuator into its displacement, hysteresis included,
and a desired displacement into the voltage that yields it.
</p>
<ol>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.Tutorial\">Tutorial</a>: from drag and drop to a closed loop, in five steps.</li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.Concept\">Concept</a>: a chain of stages, walked forwards and backwards.</li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.Equations\">Equations</a>: the model and its inverse.</li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">Effects</a>: what surrounds the fuzzy system.</li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a>: what is sampled when.</li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.ExternalCode\">External code</a>: how the FMUs come into a model.</li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.References\">References</a></li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.ReleaseNotes\">Release notes</a></li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.Contact\">Contact</a></li>
</ol>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end UsersGuide;
