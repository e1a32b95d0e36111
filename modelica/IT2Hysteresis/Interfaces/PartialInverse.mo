within IT2Hysteresis.Interfaces;
partial block PartialInverse "Feedforward: from desired displacement to voltage"
  extends IT2Hysteresis.Icons.Inverse;
  extends IT2Hysteresis.Interfaces.PartialChain;
  Modelica.Blocks.Interfaces.RealInput reference(
    final quantity="Length",
    final unit="m",
    displayUnit="um",
    nominal=1e-5)
    "Desired displacement, y_k of (30)"
    annotation (Placement(transformation(extent={{-140,-20},{-100,20}})));
  Modelica.Blocks.Interfaces.RealOutput voltage(
    final quantity="ElectricPotential",
    final unit="V",
    nominal=100,
    start=IT2Hysteresis.Functions.Effects.saturation(
      parameters.voltageMin,
      parameters.voltageMax,
      IT2Hysteresis.Functions.Effects.saturation(chain.lowest, chain.highest, chain.voltageRest)),
    fixed=true)
    "Voltage that takes the plant to the reference, x_inv(k) of (30)"
    annotation (Placement(transformation(extent={{100,-10},{120,10}})));
  Modelica.Blocks.Interfaces.BooleanOutput saturated(start=false, fixed=true)
    "True while the plant does not follow: reference or voltage are kept to their limits, or the plant is on its way back"
    annotation (Placement(transformation(extent={{100,-70},{120,-50}})));
  annotation (Documentation(info="<html>
<p>
Interface of the inverse. A realisation computes <code>voltage</code> and <code>saturated</code> at every tick, see
<a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a>. Before the first tick, <code>voltage</code> is the one
within its limits that comes nearest to holding the plant at its initial displacement.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PartialInverse;
