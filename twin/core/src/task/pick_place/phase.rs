//! Phases of pick and place, in order.

/// A phase of the task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Hovers at the start while estimator and adapter settle.
    Settle,
    /// Flies above the cube and moves the arm to the grasp pose.
    Approach,
    /// Waits above the cube until the tip is centred and slow.
    Align,
    /// Descends to just above the cube, and pauses when off centre.
    Descend,
    /// Descends quickly around the cube.
    Plunge,
    /// Waits for a centred moment.
    Dwell,
    /// Closes the fingers.
    Close,
    /// Lifts the cube.
    Lift,
    /// Hovers still and weighs: the residual gives the payload, the cameras the position of the cube in the hand.
    Weigh,
    /// Moves the arm to the transit pose and the base to the start of the path.
    Fold,
    /// Follows the path.
    Carry,
    /// Moves the arm to the grasp pose above the place.
    Extend,
    /// Waits above the place until centred.
    PlaceAlign,
    /// Descends to just above the surface.
    PlaceDescend,
    /// Waits for a centred moment.
    PlaceWait,
    /// Descends until the surface carries the cube.
    PlacePlunge,
    /// In contact with the surface; the adaptation is frozen.
    Touchdown,
    /// Opens the fingers.
    Open,
    /// Draws the hand up from the cube.
    Retreat,
    /// Climbs away.
    Leave,
    /// Hovers; the task is then done.
    Rest,
}

impl Phase {
    /// Whether the picking half of the task handles the phase.
    pub(super) fn picks(self) -> bool {
        (self as u8) <= (Self::Weigh as u8)
    }

    /// Whether the gripper is commanded to close.
    pub(super) fn grips(self) -> bool {
        (Self::Close as u8..=Self::Touchdown as u8).contains(&(self as u8))
    }

    /// Whether the payload hangs in the gripper and moves with it.
    pub(super) fn transports(self) -> bool {
        (Self::Lift as u8..=Self::PlacePlunge as u8).contains(&(self as u8))
    }

    /// Name in scenarios and recordings; it never changes.
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

    /// Sentence for the event list.
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
            Self::Touchdown => "touched down, adaptation frozen",
            Self::Open => "opening the fingers",
            Self::Retreat => "drawing the hand back",
            Self::Leave => "climbing away",
            Self::Rest => "hovering, task done",
        }
    }
}
