within IT2Hysteresis.UsersGuide;
class References "References"
  extends Modelica.Icons.References;
  annotation (DocumentationClass=true, Documentation(info="<html>
<dl>
<dt>The paper</dt>
<dd>P.-Z. Li, D.-F. Zhang, J.-Y. Hu, B. Lennox and F. Arvin: <em>Hysteresis Modelling and Feedforward Control of Piezoelectric
Actuator Based on Simplified Interval Type-2 Fuzzy System</em>. Sensors 20 (9), 2587, 2020,
<a href=\"https://doi.org/10.3390/s20092587\">doi:10.3390/s20092587</a>. Equation numbers in this library are the paper's.</dd>
<dt>Type-2 fuzzy systems</dt>
<dd>M. Nie and W. W. Tan: <em>Towards an efficient type-reduction method for interval type-2 fuzzy logic systems</em>. IEEE
International Conference on Fuzzy Systems, 2008, pages 1425 to 1432. The output (10) without type reduction.</dd>
<dt>Play operators</dt>
<dd>K. Kuhnen: <em>Modeling, identification and compensation of complex hysteretic nonlinearities: a modified
Prandtl-Ishlinskii approach</em>. European Journal of Control 9 (4), 2003, pages 407 to 418.</dd>
<dt>Reciprocal actuators</dt>
<dd>M. Goldfarb and N. Celanovic: <em>Modeling piezoelectric stack actuators for control of micromanipulation</em>. IEEE Control Systems
Magazine 17 (3), 1997, <a href=\"https://doi.org/10.1109/37.588158\">doi:10.1109/37.588158</a>.</dd>
<dt>Modelica</dt>
<dd><a href=\"https://specification.modelica.org\">Modelica Language Specification</a>, version 3.6</dd>
<dt>FMI</dt>
<dd><a href=\"https://fmi-standard.org\">Functional Mock-up Interface</a>, version 2.0</dd>
<dt>SSP</dt>
<dd><a href=\"https://ssp-standard.org\">System Structure and Parameterization</a>, version 1.0: the format of the parameter
sets that records are exported from</dd>
</dl>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end References;
