within ;
package Modelica "As much of the Modelica Standard Library 4.0.0 as IT2Hysteresis uses, for compilers without it"
  package Icons
    partial package Package end Package;
    partial package ExamplesPackage end ExamplesPackage;
    partial package FunctionsPackage end FunctionsPackage;
    partial package IconsPackage end IconsPackage;
    partial package InterfacesPackage end InterfacesPackage;
    partial package RecordsPackage end RecordsPackage;
    partial package VariantsPackage end VariantsPackage;
    partial class Information end Information;
    partial class Contact end Contact;
    partial class References end References;
    partial class ReleaseNotes end ReleaseNotes;
    partial model Example end Example;
    partial function Function end Function;
    partial record Record end Record;
  end Icons;

  package Units
    package SI
      type ElectricPotential = Real(final quantity="ElectricPotential", final unit="V");
      type Voltage = ElectricPotential;
      type Length = Real(final quantity="Length", final unit="m");
      type Velocity = Real(final quantity="Velocity", final unit="m/s");
      type Angle = Real(final quantity="Angle", final unit="rad");
      type Frequency = Real(final quantity="Frequency", final unit="Hz");
      type Force = Real(final quantity="Force", final unit="N");
      type Temperature = Real(final quantity="ThermodynamicTemperature", final unit="K");
      type Time = Real(final quantity="Time", final unit="s");
    end SI;
  end Units;

  package Constants
    final constant Real inf=1.7976931348623157E+308;
    final constant Real pi=3.141592653589793238462643383279502884;
  end Constants;

  package Blocks
    package Interfaces
      connector RealInput = input Real;
      connector RealOutput = output Real;
      connector BooleanOutput = output Boolean;
    end Interfaces;

    package Math
      block Add
        Interfaces.RealInput u1;
        Interfaces.RealInput u2;
        Interfaces.RealOutput y;
      equation
        y = u1 + u2;
      end Add;
    end Math;

    package Sources
      block Sine
        parameter Real amplitude=1;
        parameter Real f;
        parameter Real phase=0;
        parameter Real offset=0;
        Interfaces.RealOutput y;
      equation
        y = offset + amplitude*sin(2*Constants.pi*f*time + phase);
      end Sine;
    end Sources;
  end Blocks;
end Modelica;
