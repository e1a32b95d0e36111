within IT2Hysteresis.UsersGuide;
class ReleaseNotes "Release notes"
  extends Modelica.Icons.ReleaseNotes;
  annotation (DocumentationClass=true, Documentation(info="<html>
<h4>Version 0.1.0</h4>
<ul>
<li>The fuzzy model (10) and its inverse (30) as functions and as sampled blocks in pure Modelica.</li>
<li>Parameter records, generated from the table of variables that the FMUs are generated from.</li>
</ul>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end ReleaseNotes;
