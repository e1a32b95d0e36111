within IT2Hysteresis.Internal;
class PlantObject "An instance of the FMU IT2Plant"
  extends ExternalObject;

  function constructor "Instantiates the FMU with a parameter set and initializes it"
    extends Modelica.Icons.Function;
    input Real scalars[:] "Scalar parameters in SI units, in the order of Parameters.Base";
    input Modelica.Units.SI.Length ruleSigmaLower[:] "Deviations of the lower memberships, s_l1";
    input Modelica.Units.SI.Length ruleSigmaUpper[:] "Deviations of the upper memberships, s_l2";
    input Modelica.Units.SI.Length ruleCentre[:] "Centres of the antecedents, c_l";
    input Real ruleQ1[:] "Coefficients of y_{k-1}, q_l1";
    input Real ruleQ2[:] "Coefficients of x_k, q_l2";
    input Modelica.Units.SI.Length ruleQ3[:] "Constants, q_l3";
    input Modelica.Units.SI.Voltage playThreshold[:] "Thresholds of the play operators";
    input Real playWeight[:] "Weights of the play operators";
    input Real creepGain[:] "Gains of the creep terms";
    input Modelica.Units.SI.Time creepTimeConstant[:] "Time constants of the creep terms";
    output PlantObject object "The instance, before its first tick";
  external"C" object = IT2Plant_construct(
      scalars,
      size(scalars, 1),
      ruleSigmaLower,
      ruleSigmaUpper,
      ruleCentre,
      ruleQ1,
      ruleQ2,
      ruleQ3,
      size(ruleQ3, 1),
      playThreshold,
      playWeight,
      size(playWeight, 1),
      creepGain,
      creepTimeConstant,
      size(creepTimeConstant, 1))
    annotation (
      Include="#include \"IT2Hysteresis.h\"",
      IncludeDirectory="modelica://IT2Hysteresis/Resources/C-Sources");
    annotation (Documentation(info="<html>
<p>
Calls fmi2Instantiate, fmi2SetInteger and fmi2SetReal for the parameters, fmi2SetupExperiment,
fmi2EnterInitializationMode and fmi2ExitInitializationMode of IT2Plant. Vectors have the lengths that the record's counts say.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
  end constructor;

  function destructor "Terminates the FMU and frees it"
    extends Modelica.Icons.Function;
    input PlantObject object "The instance";
  external"C" IT2Plant_destruct(object)
    annotation (
      Include="#include \"IT2Hysteresis.h\"",
      IncludeDirectory="modelica://IT2Hysteresis/Resources/C-Sources");
    annotation (Documentation(info="<html>
<p>
Calls fmi2Terminate, fmi2FreeFMUstate and fmi2FreeInstance of IT2Plant.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
  end destructor;
  annotation (Documentation(info="<html>
<p>
The constructor instantiates IT2Plant, sets every parameter and initializes it. A parameter set that the FMU refuses
stops the simulation there, with the FMU's own message. The destructor terminates the FMU and frees it.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PlantObject;
