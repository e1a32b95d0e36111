within ;
package Modelica "As much of the Modelica Standard Library 4.0.0 as IT2Hysteresis uses, for compilers without it"
  package Icons
    partial package Package end Package;
    partial package ExamplesPackage end ExamplesPackage;
    partial package FunctionsPackage end FunctionsPackage;
    partial package IconsPackage end IconsPackage;
    partial package InternalPackage end InternalPackage;
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
      type Mass = Real(final quantity="Mass", final unit="kg", min=0);
      type TranslationalSpringConstant = Real(final quantity="TranslationalSpringConstant", final unit="N/m");
      type TranslationalDampingConstant = Real(final quantity="TranslationalDampingConstant", final unit="N.s/m");
      type Acceleration = Real(final quantity="Acceleration", final unit="m/s2");
      type Capacitance = Real(final quantity="Capacitance", final unit="F", min=0);
      type Current = Real(final quantity="ElectricCurrent", final unit="A");
      type Charge = Real(final quantity="ElectricCharge", final unit="C");
      type Conductance = Real(final quantity="Conductance", final unit="S");
      type HeatFlowRate = Real(final quantity="Power", final unit="W");
      type HeatCapacity = Real(final quantity="HeatCapacity", final unit="J/K");
      type ThermalConductance = Real(final quantity="ThermalConductance", final unit="W/K");
      type Resistance = Real(final quantity="Resistance", final unit="Ohm");
      type Power = Real(final quantity="Power", final unit="W");
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

  package Math
    package Random
      package Generators
        package Xorshift64star "Other numbers than the standard library's: that one is external C"
          constant Integer nState=2;
          function initialState
            input Integer localSeed;
            input Integer globalSeed;
            output Integer state[2];
          algorithm
            state := {localSeed, globalSeed};
          end initialState;
          function random
            input Integer stateIn[2];
            output Real result;
            output Integer stateOut[2];
          algorithm
            result := mod(0.6180339887498949*stateIn[1] + 0.5, 1);
            stateOut := {stateIn[1] + 1, stateIn[2]};
          end random;
        end Xorshift64star;
      end Generators;
    end Random;

    package Distributions
      package Normal
        function quantile "A logistic distribution's, of the same mean and deviation"
          input Real u;
          input Real mu=0;
          input Real sigma=1;
          output Real y;
        algorithm
          y := mu + sigma*sqrt(3)/Constants.pi*log(u/(1 - u));
        end quantile;
      end Normal;
    end Distributions;
  end Math;

  package Electrical
    package Analog
      package Interfaces
        connector PositivePin
          Real v;
          flow Real i;
        end PositivePin;
        connector NegativePin
          Real v;
          flow Real i;
        end NegativePin;
        partial model ConditionalHeatPort
          parameter Boolean useHeatPort=false annotation (Evaluate=true);
          parameter Units.SI.Temperature T=293.15;
          Thermal.HeatTransfer.Interfaces.HeatPort_a heatPort(final T=T_heatPort, final Q_flow=-LossPower)
            if useHeatPort;
          Units.SI.Power LossPower;
          Units.SI.Temperature T_heatPort;
        equation
          if not useHeatPort then
            T_heatPort = T;
          end if;
        end ConditionalHeatPort;
      end Interfaces;

      package Basic
        model Ground
          Interfaces.PositivePin p;
        equation
          p.v = 0;
        end Ground;
      end Basic;
    end Analog;
  end Electrical;

  package Mechanics
    package Translational
      package Interfaces
        connector Flange_a
          Real s;
          flow Real f;
        end Flange_a;
        connector Flange_b
          Real s;
          flow Real f;
        end Flange_b;
        connector Support
          Real s;
          flow Real f;
        end Support;
        partial model PartialElementaryTwoFlangesAndSupport2
          parameter Boolean useSupport=false annotation (Evaluate=true);
          Flange_a flange_a;
          Flange_b flange_b;
          Support support(s=s_support, f=-flange_a.f - flange_b.f) if useSupport;
          Units.SI.Length s_a;
          Units.SI.Length s_b;
        protected
          Units.SI.Length s_support;
        equation
          s_a = flange_a.s - s_support;
          s_b = flange_b.s - s_support;
          if not useSupport then
            s_support = 0;
          end if;
        end PartialElementaryTwoFlangesAndSupport2;
      end Interfaces;

      package Components
        model Fixed
          parameter Real s0=0;
          Interfaces.Flange_b flange;
        equation
          flange.s = s0;
        end Fixed;

        model Mass
          parameter Real m;
          parameter Real L=0;
          Interfaces.Flange_a flange_a;
          Interfaces.Flange_b flange_b;
          Real s;
          Real v;
          Real a;
        equation
          flange_a.s = s - L/2;
          flange_b.s = s + L/2;
          v = der(s);
          a = der(v);
          m*a = flange_a.f + flange_b.f;
        end Mass;

        model SpringDamper
          parameter Real c;
          parameter Real d;
          parameter Real s_rel0=0;
          Interfaces.Flange_a flange_a;
          Interfaces.Flange_b flange_b;
          Real s_rel;
          Real v_rel;
          Real f;
        equation
          s_rel = flange_b.s - flange_a.s;
          v_rel = der(s_rel);
          f = c*(s_rel - s_rel0) + d*v_rel;
          flange_b.f = f;
          flange_a.f = -f;
        end SpringDamper;
      end Components;

      package Sources
        model Force
          Blocks.Interfaces.RealInput f;
          Interfaces.Flange_b flange;
        equation
          flange.f = -f;
        end Force;
      end Sources;
    end Translational;
  end Mechanics;

  package Thermal
    package HeatTransfer
      package Interfaces
        connector HeatPort_a
          Units.SI.Temperature T;
          flow Units.SI.HeatFlowRate Q_flow;
        end HeatPort_a;
        connector HeatPort_b
          Units.SI.Temperature T;
          flow Units.SI.HeatFlowRate Q_flow;
        end HeatPort_b;
      end Interfaces;

      package Components
        model HeatCapacitor
          parameter Units.SI.HeatCapacity C;
          Units.SI.Temperature T(start=293.15);
          Interfaces.HeatPort_a port;
        equation
          T = port.T;
          C*der(T) = port.Q_flow;
        end HeatCapacitor;
        model ThermalConductor
          parameter Units.SI.ThermalConductance G;
          Interfaces.HeatPort_a port_a;
          Interfaces.HeatPort_b port_b;
        equation
          port_a.Q_flow = G*(port_a.T - port_b.T);
          port_b.Q_flow = -port_a.Q_flow;
        end ThermalConductor;
      end Components;

      package Sources
        model FixedTemperature
          parameter Units.SI.Temperature T;
          Interfaces.HeatPort_b port;
        equation
          port.T = T;
        end FixedTemperature;
        model PrescribedHeatFlow
          Blocks.Interfaces.RealInput Q_flow;
          Interfaces.HeatPort_b port;
        equation
          port.Q_flow = -Q_flow;
        end PrescribedHeatFlow;
      end Sources;
    end HeatTransfer;
  end Thermal;

  package Blocks
    package Interfaces
      connector RealInput = input Real;
      connector RealOutput = output Real;
      connector BooleanOutput = output Boolean;
    end Interfaces;

    package Math
      block Gain
        parameter Real k;
        Interfaces.RealInput u;
        Interfaces.RealOutput y;
      equation
        y = k*u;
      end Gain;

      block Feedback
        Interfaces.RealInput u1;
        Interfaces.RealInput u2;
        Interfaces.RealOutput y;
      equation
        y = u1 - u2;
      end Feedback;

      block Add
        Interfaces.RealInput u1;
        Interfaces.RealInput u2;
        Interfaces.RealOutput y;
      equation
        y = u1 + u2;
      end Add;
    end Math;

    package Discrete
      block Sampler
        parameter Real samplePeriod;
        Interfaces.RealInput u;
        Interfaces.RealOutput y;
      equation
        when sample(0, samplePeriod) then
          y = u;
        end when;
      end Sampler;
    end Discrete;

    package Sources
      block RealExpression
        Interfaces.RealOutput y=0.0;
      end RealExpression;

      block Constant
        parameter Real k;
        Interfaces.RealOutput y;
      equation
        y = k;
      end Constant;

      block Pulse
        parameter Real amplitude=1;
        parameter Real width=50;
        parameter Real period;
        parameter Integer nperiod=-1;
        parameter Real offset=0;
        parameter Real startTime=0;
        Interfaces.RealOutput y;
      equation
        y = offset + (if time >= startTime and time < startTime + width/100*period then amplitude else 0);
      end Pulse;

      block Trapezoid
        parameter Real amplitude=1;
        parameter Real rising;
        parameter Real width;
        parameter Real falling;
        parameter Real period;
        parameter Integer nperiod=-1;
        parameter Real offset=0;
        parameter Real startTime=0;
        Interfaces.RealOutput y;
      protected
        parameter Real top=startTime + rising + width;
      equation
        y = offset + amplitude*(if time < startTime + rising then max(0, (time - startTime)/rising)
          else min(1, max(0, 1 - (time - top)/falling)));
      end Trapezoid;

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
