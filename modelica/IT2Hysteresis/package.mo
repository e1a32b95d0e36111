within ;
package IT2Hysteresis "Hysteresis of piezoelectric actuators and its inverse"
  extends Modelica.Icons.Package;
  annotation (
    preferredView="info",
    version="0.1.0",
    versionDate="2026-11-22",
    dateModified="2026-11-23 08:00:00Z",
    uses(Modelica(version="4.0.0")),
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Line(
          points={{-70,-60},{30,-60},{70,60}},
          color={28,108,200},
          thickness=0.5,
          smooth=Smooth.Bezier),
        Line(
          points={{70,60},{-30,60},{-70,-60}},
          color={28,108,200},
          thickness=0.5,
          smooth=Smooth.Bezier)}),
    Documentation(info="<html>
<p>
A piezoelectric actuator's displacement depends on where its voltage has been. This library models
that hysteresis with a simplified interval type-2 Takagi-Sugeno fuzzy system and inverts it in closed
form for feedforward.
</p>
<ul>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide.Tutorial\">UsersGuide.Tutorial</a> leads from drag and drop to a closed loop.</li>
<li><a href=\"modelica://IT2Hysteresis.UsersGuide\">UsersGuide</a> explains the model, its equations and its timing.</li>
<li><a href=\"modelica://IT2Hysteresis.Examples\">Examples</a> shows it at work.</li>
<li><a href=\"modelica://IT2Hysteresis.Blocks\">Blocks</a> are what is dragged into a model: plant and inverse, as FMUs or in pure Modelica.</li>
<li><a href=\"modelica://IT2Hysteresis.Components\">Components</a> are the actuator with pins and flanges, its amplifier and its sensor.</li>
</ul>
<p>
All quantities at interfaces are in SI units: V, m, N, K, s. Micrometres are display units.
</p>
<p>
Copyright (c) 2026, the it2hys developers. BSD 2-Clause License.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end IT2Hysteresis;
