//! The names under which a component exports its functions, for `component`, which has them. Most are
//! methods of both interfaces.

/// Exports the functions of the component under their names. Functions with the same arguments are
/// listed together: those of the instance alone, getters and setters.
#[doc(hidden)]
#[macro_export]
macro_rules! export_component {
    ($x:ty) => {
        const _: () = {
            use $crate::component::*;
            use $crate::entry3 as e;

            $crate::export_component! { @call $x;
                "exit-initialization-mode" fmi3ExitInitializationMode;
                "enter-event-mode" fmi3EnterEventMode;
                "enter-step-mode" fmi3EnterStepMode;
                "evaluate-discrete-states" fmi3EvaluateDiscreteStates;
                "terminate" fmi3Terminate;
                "reset" fmi3Reset;
                "enter-configuration-mode" fmi3EnterConfigurationMode;
                "exit-configuration-mode" fmi3ExitConfigurationMode;
            }
            $crate::export_component! { @get $x;
                "get-float32" fmi3GetFloat32;
                "get-float64" fmi3GetFloat64;
                "get-int8" fmi3GetInt8;
                "get-int16" fmi3GetInt16;
                "get-int32" fmi3GetInt32;
                "get-int64" fmi3GetInt64;
                "get-uint8" fmi3GetUInt8;
                "get-uint16" fmi3GetUInt16;
                "get-uint32" fmi3GetUInt32;
                "get-uint64" fmi3GetUInt64;
                "get-boolean" fmi3GetBoolean;
            }
            $crate::export_component! { @set $x;
                "set-float32" fmi3SetFloat32 f32;
                "set-float64" fmi3SetFloat64 f64;
                "set-int8" fmi3SetInt8 i8;
                "set-int16" fmi3SetInt16 i16;
                "set-int32" fmi3SetInt32 i32;
                "set-int64" fmi3SetInt64 i64;
                "set-uint8" fmi3SetUInt8 u8;
                "set-uint16" fmi3SetUInt16 u16;
                "set-uint32" fmi3SetUInt32 u32;
                "set-uint64" fmi3SetUInt64 u64;
                "set-boolean" fmi3SetBoolean u8;
            }
            // Clocks are not passed on yet: these read and write no values, so the FMU refuses them.
            $crate::export_component! { @get_clock $x;
                "get-interval-decimal" fmi3GetIntervalDecimal null_mut null_mut;
                "get-interval-fraction" fmi3GetIntervalFraction null_mut null_mut null_mut;
                "get-shift-decimal" fmi3GetShiftDecimal null_mut;
                "get-shift-fraction" fmi3GetShiftFraction null_mut null_mut;
            }
            $crate::export_component! { @set_clock $x;
                "set-clock" fmi3SetClock null;
                "set-interval-decimal" fmi3SetIntervalDecimal null;
                "set-interval-fraction" fmi3SetIntervalFraction null null;
                "set-shift-decimal" fmi3SetShiftDecimal null;
                "set-shift-fraction" fmi3SetShiftFraction null null;
            }
            $crate::export_component_co_simulation!($x);
            $crate::export_component_exchange!($x);
            $crate::export_component_methods!($x);
        };
    };
    (@call $x:ty; $($name:literal $function:ident;)*) => {
        $crate::export_component! { @methods; $($name $function(this: This) -> Status {
            e::$function::<$x>(instance(this))
        })* }
    };
    (@get $x:ty; $($name:literal $function:ident;)*) => {
        $crate::export_component! { @methods;
            $($name $function(this: This, vr: *const ValueReference, n: usize) -> Answer {
                get::<$x, _>(this, (vr, n), e::$function::<$x>)
            })*
        }
    };
    (@set $x:ty; $($name:literal $function:ident $type:ty;)*) => {
        $crate::export_component! { @methods; $($name $function(
            this: This, vr: *const ValueReference, n: usize, values: *const $type, n_values: usize
        ) -> Status {
            e::$function::<$x>(instance(this), vr, n, values, n_values)
        })* }
    };
    (@get_clock $x:ty; $($name:literal $function:ident $($null:ident)*;)*) => {
        $crate::export_component! { @methods;
            $($name $function(this: This, vr: *const ValueReference, n: usize) -> Answer {
                result(e::$function::<$x>(instance(this), vr, n $(, $null())*), List::EMPTY)
            })*
        }
    };
    (@set_clock $x:ty; $($name:literal $function:ident $($null:ident)*;)*) => {
        $crate::export_component! { @methods; $($name $function(
            this: This, vr: *const ValueReference, n: usize, _values: *const u8, _n_values: usize
        ) -> Status {
            e::$function::<$x>(instance(this), vr, n $(, $null())*)
        })* }
    };
    // Methods of both interfaces.
    (@methods; $($name:literal $function:ident($($argument:ident: $type:ty),*) -> $result:ty $run:block)*) => {$(
        #[unsafe(export_name = concat!("fmi:fmi3/co-simulation@3.0.0#[method]co-simulation-instance.", $name))]
        unsafe extern "C" fn $function($($argument: $type),*) -> $result {
            // SAFETY: the canonical ABI gives this instance and these lists.
            call(|| unsafe { $run })
        }

        const _: () = {
            #[unsafe(export_name = concat!("fmi:fmi3/model-exchange@3.0.0#[method]model-exchange-instance.", $name))]
            unsafe extern "C" fn exchange($($argument: $type),*) -> $result {
                // SAFETY: forwarded.
                unsafe { $function($($argument),*) }
            }
        };
    )*};
    (@both $x:ty; $($name:literal $function:ident($($argument:ident: $type:ty),*) $result:ty;)*) => {
        $crate::export_component! { @methods; $($name $function($($argument: $type),*) -> $result {
            $crate::component::$function::<$x>($($argument),*)
        })* }
    };
    (@one $x:ty; $($name:literal $function:ident($($argument:ident: $type:ty),*) $result:ty;)*) => {$(
        #[unsafe(export_name = concat!("fmi:fmi3/", $name))]
        unsafe extern "C" fn $function($($argument: $type),*) -> $result {
            // SAFETY: the canonical ABI gives these arguments.
            call(|| unsafe { $crate::component::$function::<$x>($($argument),*) })
        }
    )*};
}
