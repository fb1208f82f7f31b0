//! Phases of pick and place, in order.

/// Where the task is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Hover at the start while estimator and adapter settle.
    Settle,
    /// Fly above the cube, arm to the grasp pose.
    Approach,
    /// Wait above the cube until the tip is centred and slow.
    Align,
    /// Come down to just above the cube, pausing when off centre.
    Descend,
    /// Go down around the cube quickly.
    Plunge,
    /// Wait for a centred moment.
    Dwell,
    /// Close the fingers.
    Close,
    /// Lift the cube.
    Lift,
    /// Hang still and weigh: the residual tells the payload, the cameras where the cube sits in the hand.
    Weigh,
    /// Arm to the transit pose, base to the start of the path.
    Fold,
    /// Follow the path.
    Carry,
    /// Above the place, arm to the grasp pose.
    Extend,
    /// Wait above the place until centred.
    PlaceAlign,
    /// Come down to just above the surface.
    PlaceDescend,
    /// Wait for a centred moment.
    PlaceWait,
    /// Go down until the surface carries the cube.
    PlacePlunge,
    /// In contact: adaptation held.
    Touchdown,
    /// Open the fingers.
    Open,
    /// Draw the hand up from the cube.
    Retreat,
    /// Climb away.
    Leave,
    /// Hover, then done.
    Rest,
}

impl Phase {
    /// Phases handled by the picking half.
    pub(super) fn picks(self) -> bool {
        (self as u8) <= (Self::Weigh as u8)
    }

    /// The gripper is commanded to close.
    pub(super) fn grips(self) -> bool {
        (Self::Close as u8..=Self::Touchdown as u8).contains(&(self as u8))
    }

    /// The payload hangs in the gripper and moves with it.
    pub(super) fn transports(self) -> bool {
        (Self::Lift as u8..=Self::PlacePlunge as u8).contains(&(self as u8))
    }

    /// Stable name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Settle => "settle",
            Self::Approach => "approach",
            Self::Align => "align",
            Self::Descend => "descend",
            Self::Plunge => "plunge",
            Self::Dwell => "dwell",
            Self::Close => "close",
            Self::Lift => "lift",
            Self::Weigh => "weigh",
            Self::Fold => "fold",
            Self::Carry => "carry",
            Self::Extend => "extend",
            Self::PlaceAlign => "place_align",
            Self::PlaceDescend => "place_descend",
            Self::PlaceWait => "place_wait",
            Self::PlacePlunge => "place_plunge",
            Self::Touchdown => "touchdown",
            Self::Open => "open",
            Self::Retreat => "retreat",
            Self::Leave => "leave",
            Self::Rest => "rest",
        }
    }

    /// One sentence for the event list.
    pub(super) fn sentence(self) -> &'static str {
        match self {
            Self::Settle => "hovering at the start",
            Self::Approach => "flying above the cube",
            Self::Align => "centring above the cube",
            Self::Descend => "coming down to the cube",
            Self::Plunge => "plunging around the cube",
            Self::Dwell => "waiting for a centred moment",
            Self::Close => "closing the fingers",
            Self::Lift => "lifting",
            Self::Weigh => "weighing the payload",
            Self::Fold => "folding the arm, flying to the path",
            Self::Carry => "carrying along the path",
            Self::Extend => "stretching the arm above the place",
            Self::PlaceAlign => "centring above the place",
            Self::PlaceDescend => "coming down to the place",
            Self::PlaceWait => "waiting for a centred moment above the place",
            Self::PlacePlunge => "setting the cube down",
            Self::Touchdown => "touched down, adaptation held",
            Self::Open => "opening the fingers",
            Self::Retreat => "drawing the hand back",
            Self::Leave => "climbing away",
            Self::Rest => "hovering, task done",
        }
    }
}
