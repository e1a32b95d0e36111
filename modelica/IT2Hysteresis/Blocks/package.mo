within IT2Hysteresis;
package Blocks "Plant and inverse as input/output blocks"
  extends Modelica.Icons.Package;
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
          color={28,108,200},
          thickness=0.5,
          smooth=Smooth.Bezier),
        Line(
          points={{50,44},{-20,44},{-50,-44}},
          color={28,108,200},
          thickness=0.5,
          smooth=Smooth.Bezier),
        Line(points={{-92,0},{-72,0}}, color={0,0,127}),
        Line(points={{72,0},{92,0}}, color={0,0,127})}),
    Documentation(info="<html>
<p>
All blocks are sampled, see <a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a>: they hold for the sample time of their
parameter set, and there is no continuous variant.
</p>
<p>
The plant and its inverse, as the FMUs compute them, see
<a href=\"modelica://IT2Hysteresis.UsersGuide.ExternalCode\">External code</a>. <a href=\"modelica://IT2Hysteresis.Blocks.PureModelica\">PureModelica</a> holds their
realisations without external C code.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Blocks;
