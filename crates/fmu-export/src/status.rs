//! Inquiries about steps. Steps are synchronous, so most of them have no answer.

use crate::Model;
use crate::failure::{Failure, refuse};
use crate::ffi::{
    Boolean, DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, PENDING_STATUS, Status, Str, TERMINATED,
};
use crate::instance::Instance;
use libc::c_int;

impl<M: Model> Instance<M> {
    /// fmi2CancelStep: FMI allows it during a step only, and a synchronous step is over when fmi2DoStep returns.
    pub(crate) fn cancel_step(&mut self) -> Result<(), Failure> {
        refuse!("no step is in progress: steps are synchronous")
    }

    /// fmi2GetStatus: how the last step ended.
    pub(crate) fn status(&self, kind: c_int) -> Result<Status, Failure> {
        match kind {
            DO_STEP_STATUS => Ok(self.last_step),
            _ => refuse!("status kind = {kind}; allowed is {DO_STEP_STATUS} (fmi2DoStepStatus)"),
        }
    }

    /// fmi2GetRealStatus: end of the last successful step, s.
    pub(crate) fn real_status(&self, kind: c_int) -> Result<f64, Failure> {
        match kind {
            LAST_SUCCESSFUL_TIME => Ok(self.state.time),
            _ => refuse!(
                "status kind = {kind}; allowed is {LAST_SUCCESSFUL_TIME} (fmi2LastSuccessfulTime)"
            ),
        }
    }

    /// fmi2GetIntegerStatus: FMI 2.0 defines no Integer status.
    pub(crate) fn integer_status(&self, kind: c_int) -> Result<i32, Failure> {
        refuse!("status kind = {kind}; allowed is none, FMI 2.0 has no Integer status")
    }

    /// fmi2GetBooleanStatus: the model never ends the simulation by itself.
    pub(crate) fn boolean_status(&self, kind: c_int) -> Result<Boolean, Failure> {
        match kind {
            TERMINATED => Ok(0),
            _ => refuse!("status kind = {kind}; allowed is {TERMINATED} (fmi2Terminated)"),
        }
    }

    /// fmi2GetStringStatus: there is never a pending step to tell about.
    pub(crate) fn string_status(&self, kind: c_int) -> Result<Str, Failure> {
        match kind {
            PENDING_STATUS => Err(Failure::Discard(
                "no step is pending: steps are synchronous".to_owned(),
            )),
            _ => refuse!("status kind = {kind}; allowed is {PENDING_STATUS} (fmi2PendingStatus)"),
        }
    }
}
