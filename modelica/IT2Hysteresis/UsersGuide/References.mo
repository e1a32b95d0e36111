within IT2Hysteresis.UsersGuide;
class References "References"
  extends Modelica.Icons.References;
  annotation (DocumentationClass=true, Documentation(info="<html>
<dl>
<dt>The paper</dt>
<dd><em>Hysteresis Modelling and Feedforward Control of Piezoelectric Actuator Based on Simplified Interval Type-2 Fuzzy
System</em>. Equation numbers in this library are the paper's.</dd>
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
