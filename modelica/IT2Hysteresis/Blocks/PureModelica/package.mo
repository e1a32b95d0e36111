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
<h4>Time of a tick</h4>
<p>
In OpenModelica 1.27-dev a tick of the plant took 7.7 &#181;s while it remembered 65 voltages, and 2.5 &#181;s, or 2.9 &#181;s with every
effect, when it remembered as many as its delay is long, as it does now; 0.3 &#181;s of that are the event itself, and the block with the FMU
took 0.5 &#181;s in all. Since then a tick computes 6 exponentials with three rules instead of 12, and effects that are off call no function; that has not been timed
there again.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PureModelica;
