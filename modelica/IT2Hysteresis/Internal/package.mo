within IT2Hysteresis;
package Internal "What the library uses inside: external objects and functions"
  extends Modelica.Icons.InternalPackage;
  annotation (Documentation(info="<html>
<p>
External objects that hold an instance of an FMU, what makes a vector of its parameters, and the functions that let it tick. The functions of FMI 2.0 are
compiled from the C sources in <code>Resources/C-Sources</code>, which every external function includes by
one header. Not meant to be used from outside.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Internal;
