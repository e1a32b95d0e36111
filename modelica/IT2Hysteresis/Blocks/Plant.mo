within IT2Hysteresis.Blocks;
block Plant "Actuator with hysteresis, by the FMU IT2Plant: from voltage to displacement"
  extends IT2Hysteresis.Interfaces.PartialPlant;
protected
  IT2Hysteresis.Internal.Values all(parameters=parameters, initialDisplacement=initialDisplacement)
    "What the FMU is made with";
  IT2Hysteresis.Internal.PlantObject fmu=IT2Hysteresis.Internal.PlantObject(all.vector, getInstanceName())
    "The FMU";
algorithm
  when sample(0, parameters.sampleTime) then
    (displacement,measured,outOfRange) := IT2Hysteresis.Internal.plantTick(
      fmu,
      time,
      voltage,
      forceInternal,
      temperatureInternal);
  end when;
  annotation (
    defaultComponentName="plant",
    Icon(
      coordinateSystem(preserveAspectRatio=true, extent={{-100,-100},{100,100}}),
      graphics={
        Text(
          extent={{4,-60},{96,-96}},
          textString="FMU",
          textColor={28,108,200})}),
    Documentation(info="<html>
<p>
The co-simulation FMU <code>IT2Plant</code>, compiled from its C sources: at every tick
t<sub>k</sub> = k <code>parameters.sampleTime</code> the block hands its inputs to the FMU and lets it make one step, see
<a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a>. All effects of the
<a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">chain</a> are there. The same in pure Modelica is
<a href=\"modelica://IT2Hysteresis.Blocks.PureModelica.Plant\">PureModelica.Plant</a>.
</p>
<p>
A parameter set that the FMU refuses stops the simulation at its initialization with the FMU's message. Leaving the range
that the parameters are valid for is a warning, which the FMU gives once; <code>outOfRange</code> is true as long as it is
left.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Plant;
