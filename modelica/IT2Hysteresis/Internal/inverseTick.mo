within IT2Hysteresis.Internal;
impure function inverseTick "One tick of the FMU IT2Inverse"
  extends Modelica.Icons.Function;
  input IT2Hysteresis.Internal.InverseObject object "The instance";
  input Modelica.Units.SI.Time t "Time of the tick";
  input Modelica.Units.SI.Length reference "Desired displacement at this tick, y_k";
  input Modelica.Units.SI.Force force "External force, compressive positive";
  input Modelica.Units.SI.Temperature temperature "Temperature of the stage";
  output Modelica.Units.SI.Voltage voltage "Voltage at this tick, x_inv(k)";
  output Boolean saturated "True while the plant does not follow";
external"C" IT2Inverse_tick(object, t, reference, force, temperature, voltage, saturated)
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
end inverseTick;
