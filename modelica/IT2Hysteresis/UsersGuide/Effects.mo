within IT2Hysteresis.UsersGuide;
class Effects "What surrounds the fuzzy system"
  extends Modelica.Icons.Information;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>
The paper's fuzzy system is the middle of a chain. The stages around it are effects: delay and limits of the amplifier,
memory, load, creep, mechanics, drift, a static curve, and hum. All are off by default, so that the default plant is the
paper's model exactly, and each is switched on by its parameters in the record; 0 is off. In this order the voltage passes
them:
</p>
<table border=\"1\" cellspacing=\"0\" cellpadding=\"3\">
<tr><th>Effect</th><th>Parameters</th><th>Equation at tick k</th><th>Inverse</th></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.delayed\">Delay</a></td><td><code>delayTime</code></td><td>y<sub>k</sub> = x at t<sub>k</sub> - delayTime</td><td>none: the inverse drives the chain behind it</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.slew\">Slew limit</a></td><td><code>slewRate</code></td><td>|y<sub>k</sub> - y<sub>k-1</sub>| &#8804; slewRate T<sub>s</sub></td><td>nearest voltage</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.saturation\">Saturation</a></td><td><code>saturationMinimum, saturationMaximum</code></td><td>x within the limits</td><td>nearest voltage</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.lag\">Lag</a></td><td><code>lagTimeConstant</code></td><td>y<sub>k</sub> = y<sub>k-1</sub> + g (x<sub>k</sub> - y<sub>k-1</sub>)</td><td>exact</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.play\">Play</a></td><td><code>playThreshold, playWeight, initialDemagnetisation, initialExcursion</code></td><td>h<sub>k</sub> = x<sub>k</sub> + &#931; w<sub>j</sub> p<sub>j,k</sub></td><td>exact, by walking over the segments</td></tr>
<tr><td colspan=\"4\">the fuzzy system, (10), and its inverse, (30)</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.load\">Load</a></td><td><code>loadCompliance</code></td><td>y<sub>k</sub> = x<sub>k</sub> - c F<sub>k</sub></td><td>exact</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.creep\">Creep</a></td><td><code>creepGain, creepTimeConstant, initialCreep, initialCreepAge</code></td><td>y<sub>k</sub> = x<sub>k</sub> + &#931; c<sub>i</sub> s<sub>i,k</sub>, above <code>displacementZero</code></td><td>exact</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.resonance\">Resonance</a></td><td><code>resonanceFrequency, resonanceDamping, resonanceSamplingZero, resonanceSamplingDelay</code></td><td>y<sub>k</sub> = a<sub>1</sub> y<sub>k-1</sub> + a<sub>2</sub> y<sub>k-2</sub> + (1 - a<sub>1</sub> - a<sub>2</sub>) (x<sub>k</sub> - z x<sub>k-1</sub>)/(1 - z), resonanceSamplingDelay later</td><td>exact but for the delay, for which there is none</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.drift\">Drift</a></td><td><code>driftTemperatureCoefficient, driftRate</code></td><td>y<sub>k</sub> = x<sub>k</sub> + &#945; (T<sub>k</sub> - 293.15 K) + rate t<sub>k</sub></td><td>exact</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.nonlinearity\">Nonlinearity</a></td><td><code>nonlinearityQuadratic, ...Cubic, ...Quartic, ...Quintic, ...Sextic, ...Minimum, ...Maximum</code></td><td>y<sub>k</sub> = x<sub>k</sub> + (1 - z<sup>2</sup>) (a<sub>1</sub> + a<sub>2</sub> z + ... + a<sub>5</sub> z<sup>4</sup>), z above <code>displacementZero</code></td><td>to rounding, by halving</td></tr>
<tr><td colspan=\"4\">displacement</td></tr>
<tr><td><a href=\"modelica://IT2Hysteresis.Functions.Effects.hum\">Hum</a></td><td><code>humAmplitude, humFrequency, humPhase</code></td><td>line on <code>measured</code> only</td><td>none</td></tr>
</table>
<p>
An effect of your own, which <code>it2hys modelica PATH --effect FILE</code> puts into a copy of this library, has its parameters in the
record and is computed by the blocks that hold the FMUs, <a href=\"modelica://IT2Hysteresis.Blocks.Plant\">Plant</a> and
<a href=\"modelica://IT2Hysteresis.Blocks.Inverse\">Inverse</a>. The blocks in
<a href=\"modelica://IT2Hysteresis.Blocks.PureModelica\">pure Modelica</a> do not have it: where it is on, they stop at the initialization and say so.
</p>
<p>
To switch one off, or on, modify the record:
</p>
<pre>
parameter IT2Hysteresis.Parameters.Table1 stage(
  lagTimeConstant=2e-4,
  playThreshold={2,8},
  playWeight={0.05,0.04});
</pre>
<p>
The effects are those of the FMUs. <a href=\"modelica://IT2Hysteresis.Blocks.Plant\">Blocks.Plant</a> and
<a href=\"modelica://IT2Hysteresis.Blocks.Inverse\">Blocks.Inverse</a> run the FMUs' own C code, the blocks of
<a href=\"modelica://IT2Hysteresis.Blocks.PureModelica\">PureModelica</a> the functions of
<a href=\"modelica://IT2Hysteresis.Functions.Effects\">Functions.Effects</a>; they agree to rounding.
</p>
<p>
A displacement is what the sensor reads, and its zero is arbitrary: <code>displacementZero</code> is what it reads while the stage
rests at zero voltage for long. What scales with the stroke, creep and the static curve, acts on what lies above it.
</p>
<p>
Delay, slew limit and saturation lose information, and the inverse keeps to the displacements and voltages that the parameters
are valid for. Where that cuts off what a reference asks for, it gives the nearest voltage and shows it on
<code>saturated</code> until the plant is back. Play operators and creep, which remember for long, follow what the plant really
reaches, so that nothing winds up.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Effects;
