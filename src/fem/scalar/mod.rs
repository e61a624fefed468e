//! Elements one by one: the reference form of the lanes, and the materials that have none.

pub(super) mod element_fields;
pub(super) mod element_pressure;
pub(super) mod one_lane;
pub(super) mod rest_element;
pub(super) mod simplices;
pub(super) mod single_element;
