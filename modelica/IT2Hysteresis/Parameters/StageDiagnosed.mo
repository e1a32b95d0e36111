within IT2Hysteresis.Parameters;
record StageDiagnosed "Parameter set diagnosed from the demo's record"
  extends IT2Hysteresis.Parameters.Base(
    sampleTime=0.0001,
    initialDisplacement=-2.2806288742452797e-06,
    voltageMin=0.0,
    voltageMax=104.08202514567344,
    displacementMin=-4.03417638146612e-06,
    displacementMax=1.7079266189029664e-05,
    ruleCount=3,
    playCount=10,
    creepCount=3,
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
    initialExcursion=-1.9381470073958896e-15,
    initialCreep=-1.1512697390425972e-05,
    nonlinearityMinimum=-7.465820312500002e-07,
    nonlinearityMaximum=1.6783203125000003e-05,
    displacementZero=0.0,
    ruleSigmaLower={6.247119825356801e-06, 4.204603740931561e-06, 4.8981629736050435e-06},
    ruleSigmaUpper={2.004811678664181e-05, 0.00012613811222794683, 1.718541279368409e-05},
    ruleCentre={1.1563998142035966e-05, 9.164015064980726e-06, 1.1452558833588594e-05},
    ruleQ1={6.0546135295999814, -0.846908183733561, -6.843019866027943},
    ruleQ2={3.2328870139237116e-07, 1.9388384936559075e-07, -3.1426139104699474e-07},
    ruleQ3={-7.84653598828125e-05, -4.781147029610086e-05, 0.0001517029623912172},
    playThreshold={1.426450515820391, 4.034611331054588, 7.4120543036512485, 11.411604126563129, 15.948201599570167, 20.964455442538927, 26.41823325680393, 32.276890648436705, 38.51416392715056, 45.10832599514484},
    playWeight={0.04949559156467482, 0.06705688168689977, 0.07478130338770554, 0.07740528084621084, 0.07638549807190907, 0.07247812951809135, 0.06614697511308142, 0.057697359162193394, 0.047320582301793056, 0.03433456976198554},
    creepGain={0.02076209853183113, 0.004365812451310539, 0.007212116581626288},
    creepTimeConstant={0.004116493608160795, 0.03662878293640664, 0.25636852494442713});
  annotation (
    defaultComponentPrefixes="parameter",
    Documentation(info="<html>
<p>
The parameter set <em>diagnosed from the demo&#x27;s record</em>, written by it2hys. Numbers are in SI units.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end StageDiagnosed;
