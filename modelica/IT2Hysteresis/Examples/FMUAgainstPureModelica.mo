within IT2Hysteresis.Examples;
model FMUAgainstPureModelica "The FMUs and the blocks in pure Modelica, with all effects"
  extends Modelica.Icons.Example;
  parameter IT2Hysteresis.Parameters.Table1 stage(
    initialDisplacement=5e-6,
    delayTime=1.5e-4,
    slewRate=1e4,
    saturationMinimum=5,
    saturationMaximum=90,
    lagTimeConstant=2e-4,
    playThreshold={2,8},
    playWeight={0.04,0.06},
    loadCompliance=1e-8,
    creepGain={0.02,0.01},
    creepTimeConstant={5e-3,0.5},
    resonanceFrequency=2500,
    resonanceDamping=0.1,
    driftTemperatureCoefficient=1e-8,
    driftRate=1e-7,
    nonlinearityQuadratic=1e-7,
    nonlinearityCubic=5e-8,
    nonlinearityQuartic=-5e-8,
    humAmplitude=2e-8,
    humFrequency=50,
    humPhase=0.5) "Table 1 with every effect";
  Modelica.Blocks.Sources.Sine voltage(
    amplitude=45,
    f=40,
    offset=50) "Voltage; it rises faster and higher than the amplifier can"
    annotation (Placement(transformation(extent={{-80,40},{-60,60}})));
  Modelica.Blocks.Sources.Sine reference(
    amplitude=2e-6,
    f=20,
    phase=-Modelica.Constants.pi/2,
    offset=7e-6) "Desired displacement"
    annotation (Placement(transformation(extent={{-80,-60},{-60,-40}})));
  Modelica.Blocks.Sources.Sine force(
    amplitude=20,
    f=15,
    phase=-Modelica.Constants.pi/2,
    offset=20) "Force on the stage"
    annotation (Placement(transformation(extent={{-80,-10},{-60,10}})));
  IT2Hysteresis.Blocks.Plant plantFMU(parameters=stage, useForce=true) "FMU"
    annotation (Placement(transformation(extent={{-20,60},{0,80}})));
  IT2Hysteresis.Blocks.PureModelica.Plant plantPure(parameters=stage, useForce=true) "Pure Modelica"
    annotation (Placement(transformation(extent={{-20,20},{0,40}})));
  IT2Hysteresis.Blocks.Inverse inverseFMU(parameters=stage, useForce=true) "FMU"
    annotation (Placement(transformation(extent={{-20,-40},{0,-20}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse inversePure(parameters=stage, useForce=true)
    "Pure Modelica"
    annotation (Placement(transformation(extent={{-20,-80},{0,-60}})));
  Modelica.Blocks.Math.Feedback plantDifference "Of the two displacements"
    annotation (Placement(transformation(extent={{40,60},{60,80}})));
  Modelica.Blocks.Math.Feedback inverseDifference "Of the two voltages"
    annotation (Placement(transformation(extent={{40,-40},{60,-20}})));
equation
  connect(voltage.y, plantFMU.voltage)
    annotation (Line(points={{-59,50},{-40,50},{-40,70},{-22,70}}, color={0,0,127}));
  connect(voltage.y, plantPure.voltage)
    annotation (Line(points={{-59,50},{-40,50},{-40,30},{-22,30}}, color={0,0,127}));
  connect(reference.y, inverseFMU.reference)
    annotation (Line(points={{-59,-50},{-40,-50},{-40,-30},{-22,-30}}, color={0,0,127}));
  connect(reference.y, inversePure.reference)
    annotation (Line(points={{-59,-50},{-40,-50},{-40,-70},{-22,-70}}, color={0,0,127}));
  connect(force.y, plantFMU.force)
    annotation (Line(points={{-59,0},{-30,0},{-30,54},{-16,54},{-16,58}}, color={0,0,127}));
  connect(force.y, plantPure.force)
    annotation (Line(points={{-59,0},{-16,0},{-16,18}}, color={0,0,127}));
  connect(force.y, inverseFMU.force)
    annotation (Line(points={{-59,0},{-30,0},{-30,-46},{-16,-46},{-16,-42}}, color={0,0,127}));
  connect(force.y, inversePure.force)
    annotation (Line(points={{-59,0},{-30,0},{-30,-86},{-16,-86},{-16,-82}}, color={0,0,127}));
  connect(plantFMU.displacement, plantDifference.u1)
    annotation (Line(points={{1,70},{42,70}}, color={0,0,127}));
  connect(plantPure.displacement, plantDifference.u2)
    annotation (Line(points={{1,30},{50,30},{50,62}}, color={0,0,127}));
  connect(inverseFMU.voltage, inverseDifference.u1)
    annotation (Line(points={{1,-30},{42,-30}}, color={0,0,127}));
  connect(inversePure.voltage, inverseDifference.u2)
    annotation (Line(points={{1,-70},{50,-70},{50,-38}}, color={0,0,127}));
  annotation (
    experiment(StopTime=0.1, Interval=1e-4, Tolerance=1e-6),
    Documentation(info="<html>
<p>
The same voltage and force go to the FMU IT2Plant and to the plant in pure Modelica, the same reference to both inverses,
with every <a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">effect</a> at once. Both compute the same: the differences are
those of rounding, below 10<sup>-12</sup> of the range.
</p>
<p>
The voltage goes beyond the amplifier's slew limit and saturation, so that these act too.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/FMUAgainstPureModelica.png\" width=\"640\" alt=\"Displacement of both plants and voltage of both inverses over time\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Plant",
          identifier="plant",
          preferred=true,
          plots={
            Plot(curves={Curve(y=plantFMU.displacement, legend="FMU"), Curve(y=plantPure.displacement, legend="Pure Modelica")}),
            Plot(curves={Curve(y=plantDifference.y, legend="Difference")})}),
        Figure(
          title="Inverse",
          identifier="inverse",
          plots={
            Plot(curves={Curve(y=inverseFMU.voltage, legend="FMU"), Curve(y=inversePure.voltage, legend="Pure Modelica")}),
            Plot(curves={Curve(y=inverseDifference.y, legend="Difference")})})}));
end FMUAgainstPureModelica;
