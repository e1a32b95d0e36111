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
    "Displacement before the first tick, where the stage rests; y_{-1} of (10) where no effect is on";
  parameter Modelica.Units.SI.ElectricPotential voltageMin(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=0.0
    "Lower end of the voltage range that the parameters are valid for; the inverse keeps to it, and a plant beyond it is outOfRange";
  parameter Modelica.Units.SI.ElectricPotential voltageMax(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=110.0
    "Upper end of the voltage range that the parameters are valid for; the inverse keeps to it, and a plant beyond it is outOfRange";
  parameter Modelica.Units.SI.Length displacementMin(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Lower end of the range of the displacement, which the rules hold for; below it the core goes on as its linearisation there, and the inverse keeps its reference to it";
  parameter Modelica.Units.SI.Length displacementMax(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=1.6e-05
    "Upper end of the range of the displacement, which the rules hold for; above it the core goes on as its linearisation there, and the inverse keeps its reference to it";
  final parameter Integer ruleCount(
    final quantity="Count",
    min=1,
    max=16)=size(ruleSigmaLower, 1)
    "Number of rules L"
    annotation (Evaluate=true);
  parameter Modelica.Units.SI.Length ruleSigmaLower[:](
    each displayUnit="um",
    each min=1e-12,
    each max=1.0,
    each nominal=1e-05)=fill(0.0, 0)
    "Standard deviation s_l1 of the lower membership (8), (11)"
    annotation (Dialog(group="Rule"));
  parameter Modelica.Units.SI.Length ruleSigmaUpper[:](
    each displayUnit="um",
    each min=1e-12,
    each max=1.0,
    each nominal=1e-05)=fill(0.0, 0)
    "Standard deviation s_l2 of the upper membership (9), (12)"
    annotation (Dialog(group="Rule"));
  parameter Modelica.Units.SI.Length ruleCentre[:](
    each displayUnit="um",
    each min=-0.1,
    each max=0.1,
    each nominal=1e-05)=fill(0.0, 0)
    "Centre c_l of the antecedent"
    annotation (Dialog(group="Rule"));
  parameter Real ruleQ1[:](
    each final quantity="Ratio",
    each final unit="1",
    each min=-10.0,
    each max=10.0,
    each nominal=1.0)=fill(0.0, 0)
    "Consequent's coefficient q_l1 of y(k-1) (7)"
    annotation (Dialog(group="Rule"));
  parameter Real ruleQ2[:](
    each final quantity="Sensitivity",
    each final unit="m/V",
    each displayUnit="um/V",
    each min=-0.1,
    each max=0.1,
    each nominal=1e-08)=fill(0.0, 0)
    "Consequent's coefficient q_l2 of x(k) (7)"
    annotation (Dialog(group="Rule"));
  parameter Modelica.Units.SI.Length ruleQ3[:](
    each displayUnit="um",
    each min=-0.1,
    each max=0.1,
    each nominal=1e-05)=fill(0.0, 0)
    "Consequent's constant q_l3 (7)"
    annotation (Dialog(group="Rule"));
  final parameter Integer playCount(
    final quantity="Count",
    min=0,
    max=32)=size(playThreshold, 1)
    "Number of play operators in front of the core; 0 for none"
    annotation (Dialog(tab="Effects", group="Play"), Evaluate=true);
  parameter Modelica.Units.SI.ElectricPotential playThreshold[:](
    each min=0.0,
    each max=4000.0,
    each nominal=10.0)=fill(0.0, 0)
    "Threshold r_j of a play operator; thresholds rise from operator to operator"
    annotation (Dialog(tab="Effects", group="Play"));
  parameter Real playWeight[:](
    each final quantity="Ratio",
    each final unit="1",
    each min=-10.0,
    each max=10.0,
    each nominal=1.0)=fill(0.0, 0)
    "Weight w_j of a play operator in h = x + sum w_j play_j(x)"
    annotation (Dialog(tab="Effects", group="Play"));
  final parameter Integer creepCount(
    final quantity="Count",
    min=0,
    max=16)=size(creepGain, 1)
    "Number of creep terms; 0 for none"
    annotation (Dialog(tab="Effects", group="Creep"), Evaluate=true);
  parameter Real creepGain[:](
    each final quantity="Ratio",
    each final unit="1",
    each min=-10.0,
    each max=10.0,
    each nominal=1.0)=fill(0.0, 0)
    "Creep in the end, per displacement above displacementZero without it"
    annotation (Dialog(tab="Effects", group="Creep"));
  parameter Modelica.Units.SI.Time creepTimeConstant[:](
    each displayUnit="ms",
    each min=0.0,
    each max=1000000.0,
    each nominal=0.001)=fill(0.0, 0)
    "Time constant of a creep term"
    annotation (Dialog(tab="Effects", group="Creep"));
  parameter Modelica.Units.SI.Time delayTime(
    displayUnit="ms",
    min=0.0,
    max=1000000.0,
    nominal=0.001)=0.0
    "Delay of the voltage, at most 64 sample times; 0 for none. The inverse does not look ahead: hand it the reference that much earlier"
    annotation (Dialog(tab="Effects", group="Delay"));
  parameter Real slewRate(
    final quantity="SlewRate",
    final unit="V/s",
    min=0.0,
    max=1000000000000.0,
    nominal=100000.0)=0.0
    "Largest rate of the amplifier's voltage; 0 for no limit"
    annotation (Dialog(tab="Effects", group="Slew"));
  parameter Modelica.Units.SI.ElectricPotential saturationMinimum(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=0.0
    "Lowest voltage of the amplifier; minimum and maximum both 0 for no limits"
    annotation (Dialog(tab="Effects", group="Saturation"));
  parameter Modelica.Units.SI.ElectricPotential saturationMaximum(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=0.0
    "Highest voltage of the amplifier; minimum and maximum both 0 for no limits"
    annotation (Dialog(tab="Effects", group="Saturation"));
  parameter Modelica.Units.SI.Time lagTimeConstant(
    displayUnit="ms",
    min=0.0,
    max=1000000.0,
    nominal=0.001)=0.0
    "Time constant of the amplifier's first-order lag; 0 for none"
    annotation (Dialog(tab="Effects", group="Lag"));
  parameter Real loadCompliance(
    final quantity="Compliance",
    final unit="m/N",
    min=0.0,
    max=1.0,
    nominal=1e-08)=0.0
    "Displacement lost per compressive force; 0 for a rigid actuator"
    annotation (Dialog(tab="Effects", group="Load"));
  parameter Modelica.Units.SI.Frequency resonanceFrequency(
    min=0.0,
    max=1000000000.0,
    nominal=1000.0)=0.0
    "Undamped natural frequency of the mechanics; 0 for none"
    annotation (Dialog(tab="Effects", group="Resonance"));
  parameter Real resonanceDamping(
    final quantity="Ratio",
    final unit="1",
    min=0.0,
    max=1.0,
    nominal=0.1)=0.0
    "Damping of the resonance, of critical; between 0 and 1 where there is a resonance"
    annotation (Dialog(tab="Effects", group="Resonance"));
  parameter Real resonanceSamplingZero(
    final quantity="Ratio",
    final unit="1",
    min=-0.95,
    max=0.0,
    nominal=0.3)=0.0
    "Zero of the sampled resonance: -0.27 where its input runs straight between samples; 0 for none"
    annotation (Dialog(tab="Effects", group="Resonance"));
  parameter Modelica.Units.SI.Time resonanceSamplingDelay(
    displayUnit="ms",
    min=0.0,
    max=1000000.0,
    nominal=0.001)=0.0
    "Delay behind the resonance, up to two ticks: half a tick where its input is held; the inverse does not make up for it"
    annotation (Dialog(tab="Effects", group="Resonance"));
  parameter Real driftTemperatureCoefficient(
    final quantity="TemperatureCoefficient",
    final unit="m/K",
    min=-0.001,
    max=0.001,
    nominal=1e-08)=0.0
    "Displacement per temperature above 293.15 K; 0 for none"
    annotation (Dialog(tab="Effects", group="Drift"));
  parameter Real driftRate(
    final quantity="Velocity",
    final unit="m/s",
    min=-0.001,
    max=0.001,
    nominal=1e-08)=0.0
    "Displacement per time since time 0; 0 for none"
    annotation (Dialog(tab="Effects", group="Drift"));
  parameter Modelica.Units.SI.Length nonlinearityQuadratic(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Bow of the displacement: (1 - z^2) times this, z from -1 at nonlinearity.minimum to 1 at nonlinearity.maximum, 0 beyond"
    annotation (Dialog(tab="Effects", group="Nonlinearity"));
  parameter Modelica.Units.SI.Length nonlinearityCubic(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "S-shape of the displacement: (1 - z^2) z times this"
    annotation (Dialog(tab="Effects", group="Nonlinearity"));
  parameter Modelica.Units.SI.Length nonlinearityQuartic(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Double bow of the displacement: (1 - z^2) z^2 times this"
    annotation (Dialog(tab="Effects", group="Nonlinearity"));
  parameter Modelica.Units.SI.Length humAmplitude(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Amplitude of a line on measured that is not in the voltage; 0 for none"
    annotation (Dialog(tab="Effects", group="Hum"));
  parameter Modelica.Units.SI.Frequency humFrequency(
    min=0.0,
    max=1000000000.0,
    nominal=1000.0)=0.0
    "Frequency of the hum"
    annotation (Dialog(tab="Effects", group="Hum"));
  parameter Real humPhase(
    final quantity="Angle",
    final unit="rad",
    min=-100.0,
    max=100.0,
    nominal=1.0)=0.0
    "Phase of the hum at time 0"
    annotation (Dialog(tab="Effects", group="Hum"));
  parameter Modelica.Units.SI.ElectricPotential initialDemagnetisation(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=0.0
    "Voltage at which the stage was last demagnetised, before the start; 0: a new stage"
    annotation (Dialog(tab="Effects", group="Play"));
  parameter Modelica.Units.SI.ElectricPotential initialExcursion(
    min=-2000.0,
    max=2000.0,
    nominal=100.0)=0.0
    "How far the voltage went from where the stage was demagnetised, before it came to where it rests at the start; 0: it did not"
    annotation (Dialog(tab="Effects", group="Play"));
  parameter Modelica.Units.SI.Length initialCreep(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "How far the states of creep lie above the core's displacement at the start; 0 after long rest"
    annotation (Dialog(tab="Effects", group="Creep"));
  parameter Modelica.Units.SI.Length nonlinearityMinimum(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Lower end of the curve, from displacementZero; the displacement is straight below"
    annotation (Dialog(tab="Effects", group="Nonlinearity"));
  parameter Modelica.Units.SI.Length nonlinearityMaximum(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=1.6e-05
    "Upper end of the curve, from displacementZero; the displacement is straight above"
    annotation (Dialog(tab="Effects", group="Nonlinearity"));
  parameter Modelica.Units.SI.Length displacementZero(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "What the sensor reads while the stage rests at zero voltage for long; creep and nonlinearity act on what lies above it";
  parameter Modelica.Units.SI.Length nonlinearityQuintic(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Finer shape of the displacement: (1 - z^2) z^3 times this"
    annotation (Dialog(tab="Effects", group="Nonlinearity"));
  parameter Modelica.Units.SI.Length nonlinearitySextic(
    displayUnit="um",
    min=-0.1,
    max=0.1,
    nominal=1e-05)=0.0
    "Finer shape of the displacement: (1 - z^2) z^4 times this"
    annotation (Dialog(tab="Effects", group="Nonlinearity"));
  parameter Modelica.Units.SI.Time initialCreepAge(
    displayUnit="ms",
    min=0.0,
    max=1000000.0,
    nominal=0.001)=0.0
    "How long before the start the states of creep lay initialCreep above the core's displacement; since then it stood where it is at the start"
    annotation (Dialog(tab="Effects", group="Creep"));
  annotation (
    defaultComponentPrefixes="parameter",
    Documentation(info="<html>
<p>
What identifies an actuator, plant and inverse alike. Names are those of the FMUs'
parameters, with a vector for every column of a structured one: <code>ruleCentre[l]</code>
is the FMUs' <code>rule[l].centre</code>, <code>delayTime</code> their <code>delay.time</code>.
There are no rules by default, and effects are off, see
<a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">Effects</a>.
</p>
<p>
How many rules, play operators and creep terms there are follows from the lengths of
their vectors: <code>ruleCount</code> is that of <code>ruleSigmaLower</code>, <code>playCount</code> is that of <code>playThreshold</code>, <code>creepCount</code> is that of <code>creepGain</code>.
Vectors that belong together are of one length; blocks refuse a set where they are not.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end Base;
