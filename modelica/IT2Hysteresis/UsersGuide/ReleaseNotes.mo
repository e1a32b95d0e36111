within IT2Hysteresis.UsersGuide;
class ReleaseNotes "Release notes"
  extends Modelica.Icons.ReleaseNotes;
  annotation (DocumentationClass=true, Documentation(info="<html>
<h4>Version 0.1.0</h4>
<ul>
<li>The fuzzy model (10) and its inverse (30) as functions and as sampled blocks in pure Modelica.</li>
<li>The co-simulation FMUs IT2Plant and IT2Inverse as blocks, compiled from their C sources.</li>
<li>Effects around the fuzzy system: delay, slew limit, saturation, lag, play, load, creep, resonance, drift,
nonlinearity and hum.</li>
<li>Components for mechatronic models: a piezo actuator with electrical pins and translational flanges, a voltage
amplifier and a strain gauge.</li>
<li>Parameter records, generated from the table of variables that the FMUs are generated from.</li>
</ul>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end ReleaseNotes;
