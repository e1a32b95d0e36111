within IT2Hysteresis.UsersGuide;
class Timing "What is sampled when"
  extends Modelica.Icons.Information;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>
The model is discrete, and holds for the sample time T<sub>s</sub> = <code>parameters.sampleTime</code> that it was
identified at. Ticks are at t<sub>k</sub> = k T<sub>s</sub>, k = 0, 1, ..., the events of
<code>sample(0, parameters.sampleTime)</code>. At a tick a block reads its inputs and computes its outputs, and holds
them until the next: y(t) = y<sub>k</sub> for t<sub>k</sub> &#8804; t &lt; t<sub>k+1</sub>.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/UsersGuide/timing.svg\" alt=\"The input is read at every tick; the output is held from one tick to the next\"/>
</p>
<ul>
<li>Before the first tick the plant's outputs are <code>initialDisplacement</code>, where it rests, and the voltage of the
inverse is the one within its limits that comes nearest to holding the plant there. If a simulation starts at a tick, that
value is replaced at once. What was before it is told by four parameters, all 0 by default, for a new stage that has rested
there for long. The play operators were demagnetised at the voltage <code>initialDemagnetisation</code>, and driven by
<code>initialExcursion</code> from there before they came to where the stage rests; the states of creep were
<code>initialCreep</code> above the displacement behind the fuzzy system <code>initialCreepAge</code> ago, and move
towards it.</li>
<li>Output and input of the same tick depend on each other directly. An inverse followed by a plant gives
displacement = reference at every tick, without delay. A controller that feeds the displacement back must be
sampled itself, or read <code>pre(displacement)</code>, to break the algebraic loop, as
<a href=\"modelica://IT2Hysteresis.Components.SampledPI\">SampledPI</a> does.</li>
<li>A co-simulation FMU of the same model ticks at the same times. What its master reads at the end of a communication
step is the value held since the last tick before it.</li>
</ul>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Timing;
