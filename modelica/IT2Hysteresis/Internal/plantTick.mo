within IT2Hysteresis.Internal;
impure function plantTick "One tick of the FMU IT2Plant"
  extends Modelica.Icons.Function;
  input IT2Hysteresis.Internal.PlantObject object "The instance";
  input Modelica.Units.SI.Time t "Time of the tick";
  input Modelica.Units.SI.Voltage voltage "Voltage at this tick, x_k";
  input Modelica.Units.SI.Force force "External force, compressive positive";
  input Modelica.Units.SI.Temperature temperature "Temperature of the stage";
  output Modelica.Units.SI.Length displacement "Displacement at this tick, y_k";
  output Modelica.Units.SI.Length measured "The same with hum";
  output Boolean outOfRange "True while the plant is out of its range";
external"C" IT2Plant_tick(object, t, voltage, force, temperature, displacement, measured, outOfRange)
  annotation (
    Include="#include \"IT2Hysteresis.h\"",
    IncludeDirectory="modelica://IT2Hysteresis/Resources/C-Sources");
  annotation (Documentation(info="<html>
<p>
Sets the inputs and makes a step of one sample time, which holds this one tick. A tool may evaluate an event more than
once: a tick that is evaluated again, with other inputs too, starts from the state before it, so that the last
evaluation counts. Warnings of the FMU are warnings of the tool, given once; a step that fails stops the simulation with
the FMU's message.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end plantTick;
