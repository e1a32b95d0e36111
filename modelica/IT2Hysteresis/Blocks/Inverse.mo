within IT2Hysteresis.Blocks;
block Inverse "Feedforward by the FMU IT2Inverse: from desired displacement to voltage"
  extends IT2Hysteresis.Interfaces.PartialInverse;
protected
  IT2Hysteresis.Internal.Values all(parameters=parameters, initialDisplacement=initialDisplacement)
    "What the FMU is made with";
  IT2Hysteresis.Internal.InverseObject fmu=IT2Hysteresis.Internal.InverseObject(all.vector, getInstanceName())
    "The FMU";
algorithm
  when sample(0, parameters.sampleTime) then
    (voltage,saturated) := IT2Hysteresis.Internal.inverseTick(
      fmu,
      time,
      reference,
      forceInternal,
      temperatureInternal);
  end when;
  annotation (
    defaultComponentName="inverse",
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Text(
          extent={{4,-60},{96,-96}},
          textString="FMU",
          textColor={28,108,200})}),
    Documentation(info="<html>
<p>
The co-simulation FMU <code>IT2Inverse</code>, compiled from its C sources: at every tick
t<sub>k</sub> = k <code>parameters.sampleTime</code> the block hands its inputs to the FMU and lets it make one step, see
<a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a>. The same in pure Modelica is
<a href=\"modelica://IT2Hysteresis.Blocks.PureModelica.Inverse\">PureModelica.Inverse</a>.
</p>
<p>
A reference or a voltage beyond its range is replaced by the nearest within it; <code>saturated</code> is true until the plant
is where the reference is again, and the FMU warns of it once. A parameter set that the FMU refuses stops the simulation at its initialization with the FMU's
message.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Inverse;
