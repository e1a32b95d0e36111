within IT2Hysteresis.Parameters;
record StageDiagnosed "Parameter set diagnosed from the demo's record"
  extends IT2Hysteresis.Parameters.Base(
    sampleTime=0.0001,
    initialDisplacement=-3.886929391081226e-08,
    voltageMin=0.0,
    voltageMax=104.08202514567344,
    displacementMin=-1.5739816910185456e-06,
    displacementMax=1.6856714239628462e-05,
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
    initialDemagnetisation=13.498062479831262,
    initialExcursion=1.6623001619465687e-17,
    initialCreep=-1.5320434570312518e-06,
    nonlinearityMinimum=-1.5300903320312503e-06,
    nonlinearityMaximum=1.685443115234375e-05,
    displacementZero=6.514979832320087e-07,
    nonlinearityQuintic=0.0,
    nonlinearitySextic=0.0,
    ruleSigmaLower={9.520297666148944e-07, 4.792423774206524e-06, 6.100477300989985e-06},
    ruleSigmaUpper={8.279974929899916e-06, 1.2677683223919537e-05, 6.100477300989985e-06},
    ruleCentre={3.119740169106717e-07, 8.057408331084517e-06, 9.592688981876926e-06},
    ruleQ1={0.6710586951654098, -2.233313973770753, 2.591730387763745},
    ruleQ2={3.785290723035377e-08, 3.0705449488955885e-07, -1.508999682636985e-07},
    ruleQ3={-3.226008251563911e-07, -1.9027987698906373e-06, 1.1701342587602184e-06},
    playThreshold={1.426450515820391, 4.034611331054588, 7.4120543036512485, 11.411604126563129, 15.948201599570167, 20.964455442538927, 26.41823325680393, 32.276890648436705, 38.51416392715056, 45.10832599514484},
    playWeight={0.053547653481592954, 0.07173920687820927, 0.07893321436075278, 0.08044358784161672, 0.07810786356595924, 0.0731125888797931, 0.06643238778723105, 0.058881837168271514, 0.05079587532710493, 0.04088198009602935},
    creepGain={0.013227546124991026, 0.013694543412527491, 0.016072910150017262},
    creepTimeConstant={0.0030662586599340402, 0.01866141687255819, 0.18971741490687966});
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
