//! Nothing comes in, and long waves that arrive leave.

use super::Entry;

pub(super) const ENTRY: Entry = Entry {
    name: "shallowWaterAbsorption",
    summary: "nothing comes in; long waves that arrive leave, by the flux that they bring",
    formula: "U = (h_0 - h) sqrt(g/h) inwards, h: depth of the water in front of the paddle, \
              h_0: depth at rest",
    reference: "H. A. Schaffer, G. Klopman, J. Waterw. Port Coast. Ocean Eng. 126 (2000) 88",
    ramped: false,
    read: |_, _| None,
};
