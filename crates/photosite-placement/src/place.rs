//! Places for all objects of a request.

use photosite_core::Invalid;

use crate::body::Body;
use crate::drop::dropped;
use crate::pose::Pose;
use crate::request::{Method, Request};
use crate::scatter::scatter;

/// A pose for each object, in their order: a function of the request alone, the same on every machine.
pub fn place(request: &Request) -> Result<Vec<Pose>, Invalid> {
    request.check()?;
    if request.items.is_empty() {
        return Ok(Vec::new());
    }
    let bodies: Vec<Body> =
        request.items.iter().map(|item| Body::new(&item.shape, item.scale, item.density_kg_m3)).collect();
    let fixed: Vec<(Body, Pose)> =
        request.fixed.iter().map(|fixed| (Body::new(&fixed.shape, fixed.scale, 1.0), fixed.pose)).collect();
    match &request.how {
        Method::Box { .. } | Method::Surface { .. } | Method::Rest { .. } => scatter(request, &bodies, &fixed),
        Method::Drop { .. } | Method::Stack { .. } => dropped(request, &bodies, &fixed),
    }
}
