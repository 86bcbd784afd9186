//! fmi2GetStatus and its relatives, and fmi2CancelStep, for `entry`. Steps are synchronous, so most
//! kinds of status have no value; FMI 2.0 demands fmi2Discard for them.

use super::ffi::{
    Boolean, DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, PENDING_STATUS, Status, Str, TERMINATED,
};
use super::instance::Fmi2Instance;
use crate::Model;
use crate::core::fault::{Fault, discard, refuse};
use std::ffi::c_int;

impl<M: Model> Fmi2Instance<M> {
    /// fmi2CancelStep: FMI allows it during a step only, and a synchronous step is over when
    /// fmi2DoStep returns.
    pub(crate) fn cancel_step(&mut self) -> Result<(), Fault> {
        refuse!("no step is in progress: steps are synchronous")
    }

    /// fmi2GetStatus: how the last step ended.
    pub(crate) fn status(&self, kind: c_int) -> Result<Status, Fault> {
        match kind {
            DO_STEP_STATUS => Ok(self.version.last_step),
            _ => discard!("status kind = {kind} must be {DO_STEP_STATUS} (fmi2DoStepStatus)"),
        }
    }

    /// fmi2GetRealStatus: end of the last successful step, s.
    pub(crate) fn real_status(&self, kind: c_int) -> Result<f64, Fault> {
        match kind {
            LAST_SUCCESSFUL_TIME => Ok(self.instance.state.time),
            _ => discard!(
                "status kind = {kind} must be {LAST_SUCCESSFUL_TIME} (fmi2LastSuccessfulTime)"
            ),
        }
    }

    /// fmi2GetIntegerStatus: FMI 2.0 defines no Integer status.
    pub(crate) fn integer_status(&self, kind: c_int) -> Result<i32, Fault> {
        discard!("status kind = {kind}: FMI 2.0 has no Integer status")
    }

    /// fmi2GetBooleanStatus: whether the model asked to end the simulation.
    pub(crate) fn boolean_status(&self, kind: c_int) -> Result<Boolean, Fault> {
        match kind {
            TERMINATED => Ok(self.version.terminated.into()),
            _ => discard!("status kind = {kind} must be {TERMINATED} (fmi2Terminated)"),
        }
    }

    /// fmi2GetStringStatus: there is never a pending step to describe.
    pub(crate) fn string_status(&self, kind: c_int) -> Result<Str, Fault> {
        match kind {
            PENDING_STATUS => discard!("no step is pending: steps are synchronous"),
            _ => discard!("status kind = {kind} must be {PENDING_STATUS} (fmi2PendingStatus)"),
        }
    }
}
