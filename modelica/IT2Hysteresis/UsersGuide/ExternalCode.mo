within IT2Hysteresis.UsersGuide;
class ExternalCode "How the FMUs come into a model"
  extends Modelica.Icons.Information;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>
<a href=\"modelica://IT2Hysteresis.Blocks.Plant\">Blocks.Plant</a> and
<a href=\"modelica://IT2Hysteresis.Blocks.Inverse\">Blocks.Inverse</a> hold the co-simulation FMUs <code>IT2Plant</code> and
<code>IT2Inverse</code>. Few Modelica tools import co-simulation FMUs; all of them compile external C. So the library ships the
FMUs' C sources in <code>Resources/C-Sources</code>, and the tool compiles them with the model. Nothing needs to be
installed or built before.
</p>
<ul>
<li>Every external function includes one header, <code>IT2Hysteresis.h</code>. It includes <code>it2hys.c</code>, which holds
both models and the layer on which the FMUs run them. The functions of FMI itself have no part in it.</li>
<li>An external object holds an instance. Its constructor sets the parameters and initializes it; its destructor
frees it. A model may hold any number of them.</li>
<li>At a tick, the block sets the inputs and makes one step of the sample time. A tool may evaluate an event more than
once: the step is then repeated from the state before the tick.</li>
<li>What an instance logs as an error stops the simulation with its message, by ModelicaFormatError: a parameter
set that makes no usable model at the initialization, a step without a finite result at its time. What it logs as a
warning, such as an input that leaves its range, is a warning of the tool, given once in the life of an instance.</li>
<li><code>it2hys.c</code> and <code>it2hys.h</code> are one amalgamation of all C of the project: the core, its effects, and the layer that the FMUs
run on. They are generated, and those of a release belong to its records: a library whose parts are of different versions is refused.</li>
<li>A message begins with the name of the block, and names parameters as the record does.</li>
<li>The sources are C99 and use the C standard library only. They are those of the FMUs, except for what finds the
parameter set of a packaged FMU: here it comes from the record.</li>
</ul>
<p>
Tools without external C use the blocks of <a href=\"modelica://IT2Hysteresis.Blocks.PureModelica\">PureModelica</a>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end ExternalCode;
