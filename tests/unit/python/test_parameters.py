"""What editors and shells know of camera options, against what the package takes."""

import inspect
import typing

import pytest

import camrig
from camrig import parameters
from camrig.spec import camera_params


@pytest.mark.parametrize("function", [camrig.Rig.create_camera, camrig.Camera.set])
def test_every_option_is_a_keyword_that_help_shows(function):
    shown = inspect.signature(function).parameters
    assert set(shown) >= set(parameters.CAMERA_OPTIONS)
    for name in parameters.CAMERA_OPTIONS:
        assert shown[name].kind is inspect.Parameter.KEYWORD_ONLY
        assert shown[name].annotation == parameters.CameraOptions.__annotations__[name].__forward_arg__
    assert not any(one.kind is inspect.Parameter.VAR_KEYWORD for one in shown.values())


def test_types_of_options_and_answers_can_be_evaluated():
    for known in (parameters.CameraOptions, parameters.CameraState, parameters.Lens, parameters.Controls, parameters.Output):
        assert typing.get_type_hints(known)
    assert set(typing.get_type_hints(parameters.CameraOptions)) == set(parameters.CAMERA_OPTIONS)
    assert parameters.CameraOptions.__required_keys__ == frozenset()


def test_an_option_that_does_not_exist_is_named_with_those_that_do(client_rig):
    with pytest.raises(TypeError, match="'colour' is no option of a camera; there are size, fps"):
        client_rig.create_camera("lobby", colour="red")


def test_none_is_not_given_but_where_null_means_something():
    assert camera_params(zoom=None, size=None, position=None) == {}
    assert camera_params(quality=None, mount=None) == {"quality": None, "mount": None}
    assert camera_params(mount="") == {"mount": None}
