within IT2Hysteresis.Internal;
class PlantObject "An instance of the FMU IT2Plant"
  extends ExternalObject;

  function constructor "Instantiates the FMU with a parameter set and initializes it"
    extends Modelica.Icons.Function;
    input Real values[:] "All parameters, the vector of Internal.Values";
    input String name "Name of the block, which messages begin with";
    output PlantObject object "The instance, before its first tick";
  external"C" object = IT2Plant_construct(values, size(values, 1), name)
    annotation (
      Include="#include \"IT2Hysteresis.h\"",
      IncludeDirectory="modelica://IT2Hysteresis/Resources/C-Sources");
    annotation (Documentation(info="<html>
<p>
Makes an instance of IT2Plant with these parameters, and initializes it.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
  end constructor;

  function destructor "Terminates the FMU and frees it"
    extends Modelica.Icons.Function;
    input PlantObject object "The instance";
  external"C" IT2Plant_destruct(object)
    annotation (
      Include="#include \"IT2Hysteresis.h\"",
      IncludeDirectory="modelica://IT2Hysteresis/Resources/C-Sources");
    annotation (Documentation(info="<html>
<p>
Calls fmi2Terminate, fmi2FreeFMUstate and fmi2FreeInstance of IT2Plant.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
  end destructor;
  annotation (Documentation(info="<html>
<p>
The constructor instantiates IT2Plant, sets every parameter and initializes it. A parameter set that the FMU refuses
stops the simulation there, with the FMU's own message. The destructor terminates the FMU and frees it.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PlantObject;
