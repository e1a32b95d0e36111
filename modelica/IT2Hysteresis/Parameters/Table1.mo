within IT2Hysteresis.Parameters;
record Table1 "Parameter set Table 1"
  extends IT2Hysteresis.Parameters.Base(
    sampleTime=0.0001,
    initialDisplacement=0.0,
    voltageMin=0.0,
    voltageMax=110.0,
    displacementMin=0.0,
    displacementMax=1.6e-05,
    delayTime=0.0,
    slewRate=0.0,
    saturationMinimum=0.0,
    saturationMaximum=0.0,
    lagTimeConstant=0.0,
    loadCompliance=0.0,
    resonanceFrequency=0.0,
    resonanceDamping=0.0,
    resonanceSamplingZero=0.0,
    resonanceSamplingDelay=0.0,
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
    nonlinearityMinimum=0.0,
    nonlinearityMaximum=1.6e-05,
    displacementZero=0.0,
    nonlinearityQuintic=0.0,
    nonlinearitySextic=0.0,
    initialCreepAge=0.0,
    ruleSigmaLower={4.3427e-06, 2.5647e-06, 2.1349e-06},
    ruleSigmaUpper={1.78879e-05, 1.15798e-05, 1.98162e-05},
    ruleCentre={8.92e-08, 8.6067e-06, 1.87381e-05},
    ruleQ1={0.8943, 0.914, 1.1882},
    ruleQ2={1.96e-08, 1.29e-08, 1.48e-08},
    ruleQ3={1.7504e-06, 8.773e-07, -6.2312e-06});
  annotation (
    defaultComponentPrefixes="parameter",
    Documentation(info="<html>
<p>
The parameter set <em>Table 1</em>, written by it2hys. Numbers are in SI units.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end Table1;
