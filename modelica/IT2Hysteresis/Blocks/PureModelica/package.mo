within IT2Hysteresis.Blocks;
package PureModelica "Plant and inverse without external code"
  extends Modelica.Icons.VariantsPackage;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-72,56},{72,-56}},
          lineColor={0,0,127},
          fillColor={255,255,255},
          fillPattern=FillPattern.Solid),
        Line(
          points={{-50,-44},{20,-44},{50,44}},
          color={128,128,128},
          thickness=0.5,
          smooth=Smooth.Bezier),
        Line(
          points={{50,44},{-20,44},{-50,-44}},
          color={128,128,128},
          thickness=0.5,
          smooth=Smooth.Bezier),
        Line(points={{-92,0},{-72,0}}, color={0,0,127}),
        Line(points={{72,0},{92,0}}, color={0,0,127})}),
    Documentation(info="<html>
<p>
The blocks as the <a href=\"modelica://IT2Hysteresis.UsersGuide.Equations\">equations</a> state them, by the functions of
<a href=\"modelica://IT2Hysteresis.Functions\">Functions</a>. They run in every Modelica tool, and are the reference that
other realisations are compared with.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PureModelica;
