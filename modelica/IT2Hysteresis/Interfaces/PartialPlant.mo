within IT2Hysteresis.Interfaces;
partial block PartialPlant "Actuator: from voltage to displacement"
  extends IT2Hysteresis.Icons.Plant;
  extends IT2Hysteresis.Interfaces.PartialChain;
  Modelica.Blocks.Interfaces.RealInput voltage(
    final quantity="ElectricPotential",
    final unit="V",
    nominal=100)
    "Voltage at the actuator, x_k"
    annotation (Placement(transformation(extent={{-140,-20},{-100,20}})));
  Modelica.Blocks.Interfaces.RealOutput displacement(
    final quantity="Length",
    final unit="m",
    displayUnit="um",
    nominal=1e-5,
    start=initialDisplacement,
    fixed=true)
    "What the sensor reads without hum, held from one tick to the next: y_k of (10) where no effect is on"
    annotation (Placement(transformation(extent={{100,-10},{120,10}})));
  Modelica.Blocks.Interfaces.RealOutput measured(
    final quantity="Length",
    final unit="m",
    displayUnit="um",
    nominal=1e-5,
    start=initialDisplacement,
    fixed=true)
    "The displacement with hum"
    annotation (Placement(transformation(extent={{100,-70},{120,-50}})));
  Modelica.Blocks.Interfaces.BooleanOutput outOfRange(start=false, fixed=true)
    "True while the voltage or the core's displacement is outside the range that the parameters hold for"
    annotation (Placement(transformation(extent={{100,50},{120,70}})));
  annotation (Documentation(info="<html>
<p>
Interface of the plant. A realisation computes <code>displacement</code>, <code>measured</code> and <code>outOfRange</code> at
every tick, see <a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a>. Before the first tick the first two are
<code>initialDisplacement</code>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PartialPlant;
