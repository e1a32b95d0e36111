within IT2Hysteresis.Examples;
model SlowCreep "Creep over minutes, and a feedforward that knows it"
  extends Modelica.Icons.Example;
  parameter IT2Hysteresis.Parameters.Table1 known(sampleTime=0.1, initialDisplacement=3e-6) "What a feedforward without creep knows";
  parameter IT2Hysteresis.Parameters.Table1 stage(
    sampleTime=0.1,
    initialDisplacement=3e-6,
    creepGain={0.03,0.05},
    creepTimeConstant={4,60}) "What the stage is: it creeps by 3 % within seconds and by 5 % within minutes";
  Modelica.Blocks.Sources.Trapezoid reference(
    amplitude=6e-6,
    rising=5,
    width=145,
    falling=5,
    period=300,
    nperiod=1,
    offset=3e-6,
    startTime=10) "Desired displacement: 9 um for 145 s, there and back in 5 s"
    annotation (Placement(transformation(extent={{-90,-10},{-70,10}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse without(parameters=known) "Feedforward without creep"
    annotation (Placement(transformation(extent={{-40,20},{-20,40}})));
  IT2Hysteresis.Blocks.PureModelica.Plant creeping(parameters=stage) "Stage behind it"
    annotation (Placement(transformation(extent={{10,20},{30,40}})));
  IT2Hysteresis.Blocks.PureModelica.Inverse inverse(parameters=stage) "Feedforward with creep"
    annotation (Placement(transformation(extent={{-40,-40},{-20,-20}})));
  IT2Hysteresis.Blocks.PureModelica.Plant plant(parameters=stage) "Stage behind it"
    annotation (Placement(transformation(extent={{10,-40},{30,-20}})));
equation
  connect(reference.y, without.reference)
    annotation (Line(points={{-69,0},{-56,0},{-56,30},{-42,30}}, color={0,0,127}));
  connect(reference.y, inverse.reference)
    annotation (Line(points={{-69,0},{-56,0},{-56,-30},{-42,-30}}, color={0,0,127}));
  connect(without.voltage, creeping.voltage)
    annotation (Line(points={{-19,30},{8,30}}, color={0,0,127}));
  connect(inverse.voltage, plant.voltage)
    annotation (Line(points={{-19,-30},{8,-30}}, color={0,0,127}));
  annotation (
    experiment(StopTime=300, Interval=0.1, Tolerance=1e-6),
    Documentation(info="<html>
<p>
A stage goes on after its voltage has stopped, by some percent over minutes. A feedforward without creep therefore leaves it
on the way: after 145 s at 9 &#181;m it is 0.7 &#181;m too far, and takes as long to come back. The inverse that holds the creep terms takes
so much voltage away again that the displacement stays at every tick.
</p>
<p>
Runs over minutes are made with a set that was identified at a low rate. Here it is Table 1 at 0.1 s with two creep
terms: at rest, the sample time does not matter. The reference rises in 50 ticks, because no amplifier makes a step within one.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/SlowCreep.png\" width=\"640\" alt=\"Displacement with and without knowledge of the creep, and both voltages, over 300 s\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Creep over minutes",
          identifier="creep",
          preferred=true,
          plots={
            Plot(curves={Curve(y=reference.y, legend="Reference"), Curve(y=creeping.displacement, legend="Feedforward without creep"), Curve(y=plant.displacement, legend="Feedforward with creep")}),
            Plot(curves={Curve(y=without.voltage, legend="Voltage without creep"), Curve(y=inverse.voltage, legend="Voltage with creep")})})}));
end SlowCreep;
