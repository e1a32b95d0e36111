within IT2Hysteresis;
package Components "Physical components around the plant"
  extends Modelica.Icons.Package;
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-76,30},{76,-30}},
          lineColor={0,127,0},
          fillColor={224,240,224},
          fillPattern=FillPattern.Solid),
        Line(points={{-46,30},{-46,-30}}, color={0,127,0}),
        Line(points={{-15,30},{-15,-30}}, color={0,127,0}),
        Line(points={{15,30},{15,-30}}, color={0,127,0}),
        Line(points={{46,30},{46,-30}}, color={0,127,0}),
        Line(points={{-50,70},{-50,30}}, color={0,0,255}),
        Line(points={{50,70},{50,30}}, color={0,0,255})}),
    Documentation(info="<html>
<p>
What a mechatronic model needs around the <a href=\"modelica://IT2Hysteresis.Blocks\">blocks</a>: a piezo actuator with electrical
pins and translational flanges, amplifiers of voltage and of charge, a preloaded flexure guide, a strain gauge and a position
sensor, and a sampled controller. Built from their defaults they begin at rest, at 0 V. They connect to <code>Modelica.Electrical.Analog</code> and <code>Modelica.Mechanics.Translational</code>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Components;
