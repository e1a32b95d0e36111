within IT2Hysteresis.Parameters;
record StageDiagnosed "Parameter set diagnosed from the demo's record"
  extends IT2Hysteresis.Parameters.Base(
    sampleTime=0.0001,
    initialDisplacement=-4.660992298461931e-08,
    voltageMin=0.0,
    voltageMax=104.08202514567344,
    displacementMin=-1.5823643987714546e-06,
    displacementMax=1.685667526212881e-05,
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
    initialDemagnetisation=13.555556309705661,
    initialExcursion=0.0,
    initialCreep=-1.5320434570312518e-06,
    nonlinearityMinimum=-1.5300903320312503e-06,
    nonlinearityMaximum=1.685443115234375e-05,
    displacementZero=5.670856708181477e-07,
    nonlinearityQuintic=0.0,
    nonlinearitySextic=0.0,
    initialCreepAge=0.0,
    ruleSigmaLower={1.2432328065097636e-05, 6.69424934186173e-06, 4.50720990729247e-06},
    ruleSigmaUpper={1.2432331223289255e-05, 7.745667969003882e-05, 9.931254985500918e-06},
    ruleCentre={-6.423800298731689e-06, -1.9735463960521908e-06, 1.6920325194239772e-05},
    ruleQ1={9.988765385645376, -9.030808356234646, 3.0777650191966273},
    ruleQ2={-8.012765933052406e-07, 9.112683741206359e-07, -1.8325286054203745e-07},
    ruleQ3={-1.1785886978394944e-06, 3.534002312391957e-08, -7.631889465133961e-07},
    playThreshold={1.426450515820391, 4.034611331054588, 7.4120543036512485, 11.411604126563129, 15.948201599570167, 20.964455442538927, 26.41823325680393, 32.276890648436705, 38.51416392715056, 45.10832599514484},
    playWeight={0.05337953032335321, 0.07148443477032161, 0.07861648520964165, 0.08008520942399207, 0.07773624200709908, 0.07279207019934007, 0.06626648852019602, 0.058895399558266386, 0.050846764602639274, 0.04080219087135247},
    creepGain={0.013388117345865857, 0.013894675842007773, 0.016096716374832423},
    creepTimeConstant={0.0029350538107780185, 0.018349622471976596, 0.1890430969841145});
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
