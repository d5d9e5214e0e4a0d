//! The names that URDF defines: a name close to one of these is likely a typo and would otherwise be silently ignored.

use crate::named::did_you_mean;

/// Elements, by the element that they are in.
const ELEMENTS: [(&str, &str); 7] = [
    ("robot", "link joint material gazebo transmission mujoco ros2_control plugin sensor"),
    ("link", "inertial visual collision contact sensor"),
    ("joint", "origin parent child axis calibration dynamics limit mimic safety_controller"),
    ("inertial", "origin mass inertia"),
    ("collision", "origin geometry material name verbose contact_coefficients surface"),
    ("visual", "origin geometry material name meterial plugin"),
    ("geometry", "box cylinder sphere mesh capsule plane cone ellipsoid heightmap"),
];
/// Attributes, by their element.
const ATTRIBUTES: [(&str, &str); 13] = [
    ("origin", "xyz rpy quat_xyzw rotation"),
    ("axis", "xyz rpy"),
    ("parent", "link joint"),
    ("child", "link joint"),
    ("limit", "lower upper effort velocity acceleration deceleration jerk"),
    ("mimic", "joint multiplier offset"),
    ("mass", "value"),
    ("box", "size"),
    ("sphere", "radius"),
    ("cylinder", "radius length"),
    ("capsule", "radius length"),
    ("mesh", "filename scale"),
    ("joint", "name type"),
];

/// The element that is meant by one in an element called `parent`, where it is misspelt.
pub(super) fn element_meant(parent: &str, name: &str) -> Option<&'static str> {
    meant(&ELEMENTS, parent, name)
}

/// The attribute that is meant by one of an element, where it is misspelt.
pub(super) fn attribute_meant(element: &str, name: &str) -> Option<&'static str> {
    meant(&ATTRIBUTES, element, name)
}

/// Whether what is in an element is known here: what others have put in, is theirs.
pub(super) fn is_known(element: &str) -> bool {
    ELEMENTS.iter().any(|(parent, _)| *parent == element)
}

fn meant(of: &[(&str, &'static str)], within: &str, name: &str) -> Option<&'static str> {
    let (_, known) = of.iter().find(|(parent, _)| *parent == within)?;
    let mut known = known.split(' ');
    if known.clone().any(|known| known == name) { None } else { did_you_mean(name, &mut known) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_told_from_names_of_others() {
        assert_eq!(element_meant("joint", "limi"), Some("limit"));
        assert_eq!(element_meant("inertial", "orkgin"), Some("origin"));
        assert_eq!(attribute_meant("origin", "xy"), Some("xyz"));
        assert_eq!(attribute_meant("limit", "Lower"), Some("lower"));
        for (parent, name) in
            [("joint", "limit"), ("joint", "gazebo"), ("geometry", "octomap"), ("drake", "limi")]
        {
            assert_eq!(element_meant(parent, name), None, "{name}");
        }
        assert_eq!(attribute_meant("origin", "id"), None);
    }
}
