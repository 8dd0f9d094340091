from .design import DesignedTips as DesignedTips
from .design import design_tips as design_tips
from .parameters import FingertipDesign as FingertipDesign
from .parameters import TipLimits as TipLimits
from .parameters import TipSearch as TipSearch
