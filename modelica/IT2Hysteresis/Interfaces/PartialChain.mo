within IT2Hysteresis.Interfaces;
partial block PartialChain "Parameters and inputs that plant and inverse have in common"
  replaceable record Stage = IT2Hysteresis.Parameters.Table1
    constrainedby IT2Hysteresis.Parameters.Base "Parameter set"
    annotation (choicesAllMatching=true);
  parameter Stage parameters "Parameter set, the same for a plant and its inverse";
  parameter Modelica.Units.SI.Length initialDisplacement(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-5)=parameters.initialDisplacement "Displacement before the first tick, where the stage rests"
    annotation (Dialog(tab="Initialization"));
  parameter Boolean useForce=false "= true, if the input force is used, otherwise the force is 0"
    annotation (Evaluate=true, HideResult=true, choices(checkBox=true));
  parameter Boolean useTemperature=false
    "= true, if the input temperature is used, otherwise the temperature is 20 degC"
    annotation (Evaluate=true, HideResult=true, choices(checkBox=true));
  Modelica.Blocks.Interfaces.RealInput force(final quantity="Force", final unit="N", nominal=10) if useForce
    "External force, compressive positive; acts through the load effect, which is off unless parameterised"
    annotation (Placement(transformation(extent={{-20,-20},{20,20}}, rotation=90, origin={-60,-120})));
  Modelica.Blocks.Interfaces.RealInput temperature(
    final quantity="ThermodynamicTemperature",
    final unit="K",
    displayUnit="degC",
    nominal=300) if useTemperature
    "Temperature of the stage; acts through the drift effect, which is off unless parameterised"
    annotation (Placement(transformation(extent={{-20,-20},{20,20}}, rotation=90, origin={60,-120})));
protected
  Modelica.Blocks.Interfaces.RealInput forceInternal(final quantity="Force", final unit="N")
    "Needed to connect to the conditional connector";
  Modelica.Blocks.Interfaces.RealInput temperatureInternal(
    final quantity="ThermodynamicTemperature",
    final unit="K",
    displayUnit="degC")
    "Needed to connect to the conditional connector";
  IT2Hysteresis.Internal.Constants chain(parameters=parameters, restDisplacement=initialDisplacement)
    "What follows from the parameter set";
equation
  connect(force, forceInternal);
  connect(temperature, temperatureInternal);
  if not useForce then
    forceInternal = 0;
  end if;
  if not useTemperature then
    temperatureInternal = 293.15;
  end if;
  annotation (Documentation(info="<html>
<p>
The parameter set, and the two inputs beside the signal path. They are off by default, so that a block without them
needs no connection. Before the first tick the chain is at <code>initialDisplacement</code>, as <a href=\"modelica://IT2Hysteresis.UsersGuide.Timing\">Timing</a> says:
for long if <code>initialCreep</code> is 0, and on the initial loading curve of a new stage if
<code>initialDemagnetisation</code> and <code>initialExcursion</code> are.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PartialChain;
