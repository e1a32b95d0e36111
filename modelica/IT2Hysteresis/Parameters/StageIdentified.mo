within IT2Hysteresis.Parameters;
record StageIdentified "Parameter set identified from the demo's record"
  extends IT2Hysteresis.Parameters.Base(
    sampleTime=0.0001,
    initialDisplacement=-9.710592815160825e-07,
    voltageMin=0.0,
    voltageMax=104.08202514567344,
    displacementMin=-1.5300903320312503e-06,
    displacementMax=1.685443115234375e-05,
    ruleCount=2,
    playCount=0,
    creepCount=0,
    delayTime=0.0,
    slewRate=0.0,
    saturationMinimum=0.0,
    saturationMaximum=0.0,
    lagTimeConstant=0.0,
    loadCompliance=0.0,
    resonanceFrequency=0.0,
    resonanceDamping=0.0,
    driftTemperatureCoefficient=0.0,
    driftRate=0.0,
    nonlinearityQuadratic=0.0,
    nonlinearityCubic=0.0,
    nonlinearityQuartic=0.0,
    humAmplitude=0.0,
    humFrequency=0.0,
    humPhase=0.0,
    initialDemagnetisation=0.0,
    initialExcursion=0.0,
    initialCreep=0.0,
    nonlinearityMinimum=-1.5300903320312503e-06,
    nonlinearityMaximum=1.685443115234375e-05,
    displacementZero=0.0,
    ruleSigmaLower={7.99748053989327e-07, 3.064086914062501e-05},
    ruleSigmaUpper={1.66631754381418e-05, 0.00013165377054113128},
    ruleCentre={7.296772849878469e-06, 5.632206535491439e-06},
    ruleQ1={1.542991266581053, 0.45117369610916536},
    ruleQ2={2.8503405538559923e-08, 2.8419604824262186e-08},
    ruleQ3={-5.133533825230912e-06, 2.6154264813737357e-06});
  annotation (
    defaultComponentPrefixes="parameter",
    Documentation(info="<html>
<p>
The parameter set <em>identified from the demo&#x27;s record</em>, written by it2hys. Numbers are in SI units.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end StageIdentified;
