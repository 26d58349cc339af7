//! The single film in closed form (Airy), and the two-beam form of 1991.
