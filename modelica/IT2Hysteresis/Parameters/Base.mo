within IT2Hysteresis.Parameters;
record Base "Parameters of plant and inverse"
  extends Modelica.Icons.Record;
  parameter Modelica.Units.SI.Time sampleTime(
    displayUnit="ms",
    min=1e-09,
    max=1000.0,
    nominal=0.0001)=0.0001
    "Sample time Ts; the model holds for the sample time it was identified at";
  parameter Modelica.Units.SI.Length initialDisplacement(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Displacement before the first tick, y_{-1}";
  parameter Modelica.Units.SI.ElectricPotential voltageMin(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=0.0
    "Lower end of the voltage range that the parameters are valid for; beyond it a warning is logged";
  parameter Modelica.Units.SI.ElectricPotential voltageMax(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=150.0
    "Upper end of the voltage range that the parameters are valid for; beyond it a warning is logged";
  parameter Modelica.Units.SI.Length displacementMin(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Lower end of the displacement range in which the model is invertible and contracting; the inverse keeps to it";
  parameter Modelica.Units.SI.Length displacementMax(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=1.6e-05
    "Upper end of the displacement range in which the model is invertible and contracting; the inverse keeps to it";
  parameter Integer ruleCount(
    final quantity="Count",
    min=1,
    max=16)=3
    "Number of rules L"
    annotation (Evaluate=true);
  parameter Modelica.Units.SI.Length ruleSigmaLower[ruleCount](
    each displayUnit="um",
    each min=1e-12,
    each max=1.0,
    each nominal=1e-05)
    "Standard deviation s_l1 of the lower membership (8), (11)"
    annotation (Dialog(group="Rule"));
  parameter Modelica.Units.SI.Length ruleSigmaUpper[ruleCount](
    each displayUnit="um",
    each min=1e-12,
    each max=1.0,
    each nominal=1e-05)
    "Standard deviation s_l2 of the upper membership (9), (12)"
    annotation (Dialog(group="Rule"));
  parameter Modelica.Units.SI.Length ruleCentre[ruleCount](
    each displayUnit="um",
    each min=-0.1,
    each max=0.1,
    each nominal=1e-05)
    "Centre c_l of the antecedent"
    annotation (Dialog(group="Rule"));
  parameter Real ruleQ1[ruleCount](
    each final quantity="Ratio",
    each final unit="1",
    each min=-10.0,
    each max=10.0,
    each nominal=1.0)
    "Consequent's coefficient q_l1 of y(k-1) (7)"
    annotation (Dialog(group="Rule"));
  parameter Real ruleQ2[ruleCount](
    each final quantity="Sensitivity",
    each final unit="m/V",
    each displayUnit="um/V",
    each min=-0.1,
    each max=0.1,
    each nominal=1e-08)
    "Consequent's coefficient q_l2 of x(k) (7)"
    annotation (Dialog(group="Rule"));
  parameter Modelica.Units.SI.Length ruleQ3[ruleCount](
    each displayUnit="um",
    each min=-0.1,
    each max=0.1,
    each nominal=1e-05)
    "Consequent's constant q_l3 (7)"
    annotation (Dialog(group="Rule"));
  annotation (
    defaultComponentPrefixes="parameter",
    Documentation(info="<html>
<p>
What identifies an actuator, plant and inverse alike. Names are those of the FMUs'
parameters, with a vector for every column of a structured one: <code>ruleCentre[l]</code>
is the FMUs' <code>rule[l].centre</code>. The rules have no default.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end Base;
