within IT2Hysteresis.Icons;
partial block Inverse "Icon for the inverse of a plant with hysteresis"
  annotation (
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Rectangle(
          extent={{-100,100},{100,-100}},
          lineColor={0,0,127},
          fillColor={255,255,255},
          fillPattern=FillPattern.Solid),
        Line(points={{-80,0},{80,0}}, color={192,192,192}),
        Line(points={{0,-80},{0,80}}, color={192,192,192}),
        Line(
          points={{-60,-70},{-60,30},{60,70}},
          color={162,29,33},
          thickness=0.5,
          smooth=Smooth.Bezier),
        Line(
          points={{60,70},{60,-30},{-60,-70}},
          color={162,29,33},
          thickness=0.5,
          smooth=Smooth.Bezier),
        Text(
          extent={{-150,150},{150,110}},
          textString="%name",
          textColor={0,0,255})}),
    Documentation(info="<html>
<p>The loop of the plant with its axes exchanged: voltage over displacement.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Inverse;
